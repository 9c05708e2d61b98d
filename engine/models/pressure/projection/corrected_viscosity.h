#pragma once
/// Explicit viscosity of the projection: Brookshaw's Laplacian minus its value for a linear field.
#include "engine/models/boundary/friction.h"
#include "engine/models/pressure/projection/projection_system.h"

namespace whorl {

/// a_i += A (u + dt/2 A u)_i,   (A u)_i = (D/tr B_i) 2 sum_j V W'/r [nu_ij (u_i - u_j) - nu_i G_i r],   with G_i the corrected gradient, D
/// the dimensions, W the SharpKernel inside the fluid
///
/// Second order in time, and stable for the steps for which A u alone is. On uneven particles Brookshaw's form contains a part of the first
/// derivatives. Without this part, and with the trace of the particle's own moments instead of a dense neighbourhood's, the viscosity of
/// disordered particles is right (otherwise 3 % too weak). nu_ij is the harmonic mean. At no-slip solids u_i - u_l of lattice layer l
/// behind the wall continues the shear: (1 + depth_l/height_i)(u_i - u_wall), with a factor of at most 12. Near a free surface the plain
/// form is used, because the corrected one makes water at rest boil. The plain form has a torque on fluid in rigid rotation. Free bodies
/// receive, on their surface, the opposite of their boundary particles' part of the sums.
class CorrectedViscosity {
public:
    explicit CorrectedViscosity(std::shared_ptr<ProjectionSystem> system) : system_(std::move(system)) {}
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::viscosity> mu, Read<field::velocity> u,
                    Update<field::acceleration> a);

private:
    struct Flow;
    template <class Kernel>
    Vec3 acceleration(const Kernel& W, const Flow& flow, Index i) const;

    std::shared_ptr<ProjectionSystem> system_;
    WallFriction friction_;
    Column<Vec3> middle_;  ///< velocities in the middle of the step
};

}  // namespace whorl

#pragma once
/// Explicit viscosity of the projection: Brookshaw's Laplacian minus its value for a linear field.
#include "engine/models/boundary/friction.h"
#include "engine/models/pressure/projection/projection_system.h"

namespace whorl {

/// a_i += A (u + dt/2 A u)_i,   (A u)_i = (D/tr B_i) 2 sum_j V W'/r [nu_ij (u_i - u_j) - nu_i G_i r],   G_i the corrected gradient, D the
/// dimensions, W the SharpKernel inside the fluid
///
/// Second order in the step, and stable for the steps for which A u is. Uneven neighbours give Brookshaw's form a share of the first
/// derivatives; without it, and with the trace of the moments in place of that of a dense neighbourhood, the viscosity of disordered
/// particles is right (3 % too weak else). nu_ij is the harmonic mean. At solids that the fluid sticks to, u_i - u_l of lattice layer l
/// behind the wall continues the shear: (1 + depth_l/height_i)(u_i - u_wall), the factor at most 12. Near a free surface the plain form is
/// left: the corrected one makes water at rest boil. It has a torque on fluid that turns as a whole. Free
/// bodies are pushed, on their surface, by the opposite of their layers' part of the sums.
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

#pragma once
/// Explicit viscosity of the projection: Brookshaw's Laplacian minus its value for a linear field.
#include "engine/models/boundary/friction.h"
#include "engine/models/pressure/projection/sticking.h"

namespace whorl {

/// a_i += A (u + dt/2 A u)_i,   (A u)_i = (D/tr B_i) 2 sum_j V W'/r [nu_ij (u_i - u_j) - nu_i G_i r]
/// with the corrected gradient G_i, the number of dimensions D, the harmonic mean nu_ij, the moment B_i of the neighbours (tr B_i is
/// LinearSums::trace) and, inside the fluid, the SharpKernel W.
///
/// The form is of second order in time, and stable in the same steps as a_i += (A u)_i. On uneven particles Brookshaw's form contains a
/// part of the first derivatives, which nu_i G_i r removes. tr B_i is that of the particle's own neighbours, not the value of dense
/// neighbours. Without these two changes the viscosity of disordered particles is 3 % too weak. Near a free surface nu_i G_i r is omitted,
/// because with it particles of water at rest keep moving.
///
/// At no-slip solids u_i - u_l of lattice layer l behind the wall continues the shear: (1 + depth_l/height_i)(u_i - u_wall), with a factor
/// of at most 12. Brookshaw's form exerts a torque on fluid in rigid rotation. Free bodies receive the opposite of their boundary
/// particles' part of the sums, at the body's surface.
class CorrectedViscosity {
public:
    explicit CorrectedViscosity(std::shared_ptr<ProjectionSystem> system) : system_(std::move(system)) {}
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::viscosity> mu, Read<field::velocity> u,
                    Update<field::acceleration> a);

private:
    struct Flow;
    /// Adds the layers of no-slip walls to mu sum F (u_i - u_j).
    template <class Kernel>
    void add_walls(const Kernel& W, const Flow& flow, Index i, StickingSums& sums) const;
    template <class Kernel>
    Vec3 acceleration(const Kernel& W, const Flow& flow, Index i) const;
    template <class Kernel>
    Vec3 beside_mirrors(const Kernel& W, const Flow& flow, Index i, Span<const Vec3> of_images) const;

    std::shared_ptr<ProjectionSystem> system_;
    WallFriction friction_;
    Column<Vec3> middle_;  ///< velocities in the middle of the step
};

}  // namespace whorl

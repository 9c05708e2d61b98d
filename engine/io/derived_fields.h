#pragma once
/// Fields that no stage keeps, worked out for a frame from the particles as they stand.
#include "engine/io/frame.h"
#include "engine/sim/world.h"

namespace whorl {

/// Adds those of `fields` that are derived and that the run can give:
/// vorticity:        curl u [1/s], from gradients by least squares over the neighbours: exact for linear velocities, at surfaces too
/// q_criterion:      Q [1/s^2], where the flow turns more than it strains (q_criterion())
/// spin_difference:  w - curl u/2 [1/s], what the spin has more than the flow around it; where the run has spins
void add_derived_fields(const World& world, const std::vector<std::string>& fields, Frame& frame);

/// grad u of every particle [1/s], row: component of u; 0 where a particle is alone.
Column<Mat3> velocity_gradients(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain);
/// (|W|^2 - |S|^2)/2 [1/s^2], S and W the symmetric and the antisymmetric part of a velocity gradient: positive in vortices (Hunt, Wray and
/// Moin 1988).
Real q_criterion(const Mat3& gradient);
/// curl u of every particle [1/s]; 0 where a particle is alone.
Column<Vec3> vorticity(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain);

}  // namespace whorl

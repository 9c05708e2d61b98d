#pragma once
/// Fields that no stage keeps, worked out for a frame from the particles as they stand.
#include "engine/io/frame.h"
#include "engine/sim/world.h"

namespace whorl {

/// Adds those of `fields` that are derived and that the run can give:
/// vorticity:        curl u [1/s], from gradients by least squares over the neighbours: exact for linear velocities, at surfaces too
/// spin_difference:  w - curl u/2 [1/s], what the spin has more than the flow around it; where the run has spins
void add_derived_fields(const World& world, const std::vector<std::string>& fields, Frame& frame);

/// curl u of every particle [1/s]; 0 where a particle is alone.
Column<Vec3> vorticity(Span<const Vec3> x, Span<const Vec3> u, Real support, const Domain& domain);

}  // namespace whorl

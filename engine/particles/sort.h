#pragma once
/// Order of particles along a space-filling curve, which stores neighbours in space near each other in memory.
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// The order for ParticleStore::gather() along the Hilbert curve through the particles' cells (Skilling 2004, "Programming the Hilbert
/// curve"): order[k] is the k-th particle. Particles of one cell keep their order; particles with non-finite positions are last.
/// @param cell edge of a cell [m]; the support radius is a good choice
std::vector<Index> curve_order(Span<const Vec3> x, Real cell);

}  // namespace whorl

#pragma once
/// The order of particles along a space-filling curve: neighbours in space become neighbours in memory.
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// The order for ParticleStore::gather(), by the Hilbert curve through the particles' cells (Skilling 2004, "Programming the Hilbert
/// curve"): order[k] is the particle that comes k-th. Particles of one cell keep their order; positions that are not finite come last.
/// @param cell edge of a cell [m]: the support radius is a good choice
std::vector<Index> curve_order(Span<const Vec3> x, Real cell);

}  // namespace whorl

#pragma once
/// The order of particles along a space-filling curve: neighbours in space become neighbours in memory.
#include "engine/geometry/domain.h"
#include "engine/particles/store.h"

namespace whorl {

/// Orders particles by the Hilbert curve through their cells (Skilling 2004, "Programming the Hilbert curve").
/// Stable: particles of one cell keep their order; so the same positions in the same store give the same order, for any number of threads.
class CurveSort {
public:
    /// The order for ParticleStore::gather(): order[k] is the particle that comes k-th. Positions that are not finite come last.
    /// @param cell edge of a cell [m]: the support radius is a good choice
    Span<const Index> order(Span<const Vec3> x, Real cell);

private:
    void set_keys(Span<const Vec3> x, Real cell);
    void sort_keys();

    std::vector<std::uint64_t> key_, other_key_;
    std::vector<Index> order_, other_order_;
};

}  // namespace whorl

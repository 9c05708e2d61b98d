#pragma once
/// Pairs of neighbours: compact rows, one a particle.
#include <vector>

#include "engine/geometry/domain.h"
#include "engine/particles/store.h"

namespace whorl {

/// Rows of neighbours: row i names the particles j with |x_i - x_j| < support. Never i itself.
/// Within a row the order is fixed by the positions' order in the store: the same for any number of threads.
class Pairs {
public:
    std::vector<std::size_t> first;  ///< n + 1 offsets into other
    Column<Index> other;
    Span<const Vec3> x_own, x_other;  ///< positions as they were found; must outlive the pairs' use
    Vec3 period = Vec3::Zero();       ///< Domain::period()

    Index size() const { return first.empty() ? 0 : static_cast<Index>(first.size()) - 1; }
    Index count(Index i) const { return static_cast<Index>(first[static_cast<std::size_t>(i) + 1] - first[static_cast<std::size_t>(i)]); }

    /// Calls f(j, r, distance) for each neighbour j of i, with r = x_i - x_j [m] (nearest periodic image) and distance = |r|.
    template <class F>
    void of(Index i, F&& f) const {
        const Vec3 xi = x_own[static_cast<std::size_t>(i)];
        const std::size_t end = first[static_cast<std::size_t>(i) + 1];
        const bool periodic = period != Vec3::Zero();
        for (std::size_t k = first[static_cast<std::size_t>(i)]; k < end; ++k) {
            const Index j = other[k];
            Vec3 r = xi - x_other[static_cast<std::size_t>(j)];
            if (periodic)
                for (int a = 0; a < 3; ++a)
                    if (period[a] > 0) r[a] -= period[a] * std::nearbyint(r[a] / period[a]);
            f(j, r, std::sqrt(r.squaredNorm()));
        }
    }

    /// Up to 64 neighbours at a time with their distances side by side: a loop over `count` vectorises where a call a neighbour does not.
    struct Group {
        static constexpr Index most = 64;
        Index count;
        const Index* other;
        Real r[3][most];  ///< components of x_i - x_j, m
        Real distance[most];
    };
    /// Calls f(group) until all neighbours of i have been in one.
    template <class F>
    void groups_of(Index i, F&& f) const {
        const Vec3 xi = x_own[static_cast<std::size_t>(i)];
        const std::size_t end = first[static_cast<std::size_t>(i) + 1];
        Group group;
        for (std::size_t k = first[static_cast<std::size_t>(i)]; k < end; k += Group::most) {
            group.count = static_cast<Index>(std::min<std::size_t>(Group::most, end - k));
            group.other = other.data() + k;
            for (Index l = 0; l < group.count; ++l) {
                const Vec3& xj = x_other[static_cast<std::size_t>(group.other[l])];
                for (int a = 0; a < 3; ++a) group.r[a][l] = xi[a] - xj[a];
            }
            for (int a = 0; a < 3; ++a)
                if (period[a] > 0)
                    for (Index l = 0; l < group.count; ++l) group.r[a][l] -= period[a] * std::nearbyint(group.r[a][l] / period[a]);
            for (Index l = 0; l < group.count; ++l)
                group.distance[l] = std::sqrt(group.r[0][l] * group.r[0][l] + group.r[1][l] * group.r[1][l] + group.r[2][l] * group.r[2][l]);
            f(static_cast<const Group&>(group));
        }
    }
};

/// Neighbours among the fluid, and the solid neighbours of the fluid: two types, so that a stage's signature tells them apart.
struct FluidPairs : Pairs {};
struct SolidPairs : Pairs {};

}  // namespace whorl

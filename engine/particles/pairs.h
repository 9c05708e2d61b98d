#pragma once
/// Pairs of neighbours, stored as one compact row per particle.
#include <vector>

#include "engine/geometry/domain.h"
#include "engine/particles/gather.h"
#include "engine/particles/store.h"

namespace whorl {

/// Rows of neighbours. Row i lists the particles j with |x_i - x_j| < support, without i itself. Within a row the order follows the
/// positions' order in the store, so it does not depend on the number of threads.
class Pairs {
public:
    std::vector<std::size_t> first;  ///< begin of each row in `other`, and the end of the last row
    Column<Index> other;
    Span<const Vec3> x_own, x_other;      ///< positions of the search; must outlive the use of the pairs
    Vec3 period = Vec3::Zero();           ///< Domain::period()
    Real support = 0;                     ///< m
    Column<Vec3> found_own, found_other;  ///< copies of these positions, if the search was wider than needed (NeighbourSearch::narrow)

    Index size() const { return first.empty() ? 0 : static_cast<Index>(first.size()) - 1; }
    Index count(Index i) const { return static_cast<Index>(first[i + 1] - first[i]); }

    /// Calls f(j, r, distance) for each neighbour j of i, with r = x_i - x_j [m] (nearest periodic image) and distance = |r|.
    template <class F>
    void of(Index i, F&& f) const {
        const Vec3 xi = x_own[i];
        const std::size_t end = first[i + 1];
        const bool periodic = period != Vec3::Zero();
        for (std::size_t k = first[i]; k < end; ++k) {
            const Index j = other[k];
            Vec3 r = xi - x_other[j];
            if (periodic)
                for (int a = 0; a < 3; ++a)
                    if (period[a] > 0) r[a] -= period[a] * std::nearbyint(r[a] / period[a]);
            f(j, r, std::sqrt(r.squaredNorm()));
        }
    }

    /// Up to 64 neighbours at a time with their distances in arrays. A loop over them vectorises; one call per neighbour does not.
    struct Group {
        static constexpr Index most = 64;
        Index count;
        alignas(64) Index other[most];
        alignas(64) Real r[3][most];  ///< components of x_i - x_j, m
        alignas(64) Real distance[most];
        /// `count` rounded up to a multiple of `most_lanes`, so that loops have no remainder. Entries from `count` on refer to an existing
        /// neighbour, but with a distance of the support, at which every kernel and its slope are 0.
        Index padded() const { return (count + most_lanes - 1) & -most_lanes; }
        /// out[a][l] = v[other[l]][a] for l < padded().
        void gather(const Vec3* v, Real (&out)[3][most]) const { whorl::gather(v, other, padded(), out); }
        void gather(const Real* v, Real (&out)[most]) const { whorl::gather(v, other, padded(), out); }
    };
    /// Calls f(group) for groups that together contain all neighbours of i.
    template <class F>
    void groups_of(Index i, F&& f) const {
        const Vec3 xi = x_own[i];
        const std::size_t end = first[i + 1];
        Group group;
        for (std::size_t k = first[i]; k < end; k += Group::most) {
            const Index count = static_cast<Index>(std::min<std::size_t>(Group::most, end - k));
            group.count = count;
            const Index padded = group.padded();
            const Index* const row = other.data() + k;
            for (Index l = 0; l < padded; ++l) group.other[l] = row[l < count ? l : 0];
            group.gather(x_other.data(), group.r);
            for (int a = 0; a < 3; ++a) {
                const Real x = xi[a], edge = a == 0 ? support : 0, length = period[a], inverse = length > 0 ? 1 / length : 0;
                if (length > 0)
                    for (Index l = 0; l < padded; ++l) {
                        const Real r = x - group.r[a][l];
                        group.r[a][l] = l < count ? r - length * std::nearbyint(r * inverse) : edge;
                    }
                else
                    for (Index l = 0; l < padded; ++l) group.r[a][l] = l < count ? x - group.r[a][l] : edge;
            }
            for (Index l = 0; l < padded; ++l)
                group.distance[l] =
                    std::sqrt(group.r[0][l] * group.r[0][l] + group.r[1][l] * group.r[1][l] + group.r[2][l] * group.r[2][l]);
            f(static_cast<const Group&>(group));
        }
    }
};

/// Neighbours among the fluid, and boundary particles near the fluid. They are two types, so that a stage's signature distinguishes them.
struct FluidPairs : Pairs {};
struct SolidPairs : Pairs {};

}  // namespace whorl

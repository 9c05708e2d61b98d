#pragma once
/// Compact groups of neighbouring particles, for the coarse level of two-level preconditioners.
#include <numeric>

#include "engine/core/parallel.h"
#include "engine/math/sparse_rows.h"
#include "engine/particles/pairs.h"

namespace whorl {

/// The steps of aggregate_by() that do not need neighbours.
struct Grouping {
    Span<const Vec3> x;
    const Domain& domain;
    Span<std::int32_t> group;
    int groups = 0;
    std::vector<Vec3> centre{};
    std::vector<std::int32_t> next{};

    void form_runs(Span<const std::int16_t> role, Real cell, int size);
    void find_centres();
    int drop_empty();  ///< renumbers the remaining groups @returns their number
    Real distance2(Index i, std::int32_t g) const { return domain.minimum_image(x[i] - centre[g - 1]).squaredNorm(); }
};

/// Forms groups of about `size` free particles. The groups start as equal runs along the space-filling curve. Four sweeps make them
/// compact: in each, a particle joins the group with the nearest centre among those of its neighbours (Lloyd). With the runs alone, a solve
/// would need more than twice the iterations.
/// @param neighbours neighbours(i, visit) calls visit(j) for every neighbour j of i
/// @param role field::role: only free particles are grouped @param cell edge of the curve's cells [m]
/// @param group output: 1 to the returned number of groups; 0 for particles that are not free
template <class Neighbours>
int aggregate_by(const Neighbours& neighbours, Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real cell, int size,
                 Span<std::int32_t> group) {
    constexpr int sweeps = 4;
    Grouping g{x, domain, group};
    g.form_runs(role, cell, size);
    g.next.assign(group.begin(), group.end());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        g.find_centres();
        parallel_for(static_cast<Index>(x.size()), [&](Index i) {
            const std::int32_t own = group[i];
            if (own == 0) return;
            std::int32_t best = own, last = own;
            Real nearest = g.distance2(i, own);
            neighbours(i, [&](Index j) {
                const std::int32_t other = group[j];
                if (other == 0 || other == last) return;
                last = other;
                if (const Real here = g.distance2(i, other); here < nearest) nearest = here, best = other;
            });
            g.next[i] = best;
        });
        std::copy(g.next.begin(), g.next.end(), group.begin());
    }
    return g.drop_empty();
}

/// Splits each group whose members are not connected by neighbours (two turns of a coil side by side, a thread next to its heap) into
/// connected pieces, because a rigid motion of the whole group cannot move its pieces relative to each other.
/// @param group output of aggregate_by(), updated @returns the new number of groups
template <class Neighbours>
int split_unconnected(const Neighbours& neighbours, Span<std::int32_t> group) {
    std::vector<Index> parent(group.size());  // parent of each particle in the tree of its piece
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](Index i) {
        while (parent[i] != i) {
            Index& up = parent[i];
            i = up = parent[up];
        }
        return i;
    };
    for (std::size_t i = 0; i < group.size(); ++i) {
        if (group[i] <= 0) continue;
        neighbours(static_cast<Index>(i), [&](Index j) {
            if (group[j] != group[i]) return;
            const Index a = root(static_cast<Index>(i)), b = root(j);
            parent[std::max(a, b)] = std::min(a, b);
        });
    }
    // The root of a piece is its first particle, so the number of the piece is known when its other particles are reached.
    int pieces = 0;
    for (std::size_t i = 0; i < group.size(); ++i) {
        if (group[i] <= 0) continue;
        const Index r = root(static_cast<Index>(i));
        group[i] = r == static_cast<Index>(i) ? ++pieces : group[r];
    }
    return pieces;
}

/// aggregate_by() with the rows of `pairs` as neighbours.
int form_aggregates(const Pairs& pairs, Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real cell, int size,
                    Span<std::int32_t> group);

/// Centre of each group: the mean position of its members, each at the periodic image nearest to the first member. Groups without members
/// get the origin. @param group group of each particle, from 1; 0: in no group
std::vector<Vec3d> aggregate_centres(Span<const Vec3> x, Span<const std::int32_t> group, int groups, const Domain& domain);

/// The six rigid motions of each group at the current positions: u_i = v + omega x arm_i, with the vector arm_i from the group's centre in
/// units of spacings. R is the matrix from the motions (v, omega) of all groups to the velocities u of all particles.
class RigidAggregates {
public:
    /// @param group output of form_aggregates(); particles that are not free are left out
    void place(Span<const Vec3> x, Span<const std::int16_t> role, Span<const std::int32_t> group, int groups, const Domain& domain,
               Real spacing);
    int groups() const { return static_cast<int>(centre_.size()); }
    Index size() const { return static_cast<Index>(groups_.of.size()); }  ///< particles
    /// Group of particle i, from 0; -1: in no group.
    int of(Index i) const { return groups_.of[i]; }
    const Vec3& arm(Index i) const { return arm_[i]; }
    Span<const Index> members(int g) const {
        return {groups_.member.data() + groups_.first[g], static_cast<std::size_t>(groups_.first[g + 1] - groups_.first[g])};
    }
    Span<const Vec3d> centres() const { return centre_; }
    /// For a group without members, such as a body.
    void set_centre(int g, const Vec3d& centre) { centre_[static_cast<std::size_t>(g)] = centre; }

    /// Sets load = R^T r, six sums per group.
    void restrict_to_groups(Span<const Vec3> r, Span<Real> load) const;
    /// (R motion)_i: velocity of particle i in the rigid motion of its group.
    Vec3 motion_of(Span<const Real> motion, Index i) const {
        if (of(i) < 0) return Vec3::Zero();
        const Real* m = motion.data() + 6 * static_cast<std::size_t>(of(i));
        return Vec3(m[0], m[1], m[2]) + Vec3(m[3], m[4], m[5]).cross(arm_[i]);
    }

private:
    IndexGroups groups_;
    Column<Vec3> arm_;
    std::vector<Vec3d> centre_;
};

}  // namespace whorl

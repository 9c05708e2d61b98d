#pragma once
/// Coarse level of a two-level preconditioner for a matrix A. R are the rigid motions of groups of particles, and Ac = R^T A R is factored.
/// One application of the coarse level transmits a force through a whole thread; the diagonal transmits it by only one spacing.
#include "engine/core/parallel.h"
#include "engine/math/block_cholesky.h"
#include "engine/particles/aggregates.h"

namespace whorl {

class CoarseLevel {
public:
    void clear() { groups_ = bodies_ = 0; }
    int groups() const { return groups_; }
    int groups_of_particles() const { return groups_ - bodies_; }
    /// Whether this step forms new groups. It does if there are none, every `every` steps, and at a frame time, so that a resumed run has
    /// the same groups as an uninterrupted run. Call it once per step.
    bool due(bool at_frame_time, int every) {
        const bool now = at_frame_time || groups_ == 0 || steps_ >= every;
        steps_ = now ? 1 : steps_ + 1;
        return now;
    }
    /// Updates the positions of the groups' members. @param group from aggregate_by() @param bodies centres of free bodies [m]: each is a
    /// group of its own after the others, and its velocity and angular velocity are two unknowns after the particles. No coarse level
    /// without groups of particles
    void place(Span<const Vec3> x, Span<const std::int16_t> role, Span<const std::int32_t> group, int groups, const Domain& domain,
               Real spacing, Span<const Vec3d> bodies = {});
    const RigidAggregates& motions() const { return motions_; }
    /// Factors Ac. If it is not definite, there is no coarse level.
    void factor(const SymmetricBlocks& Ac);
    /// z += R Ac^-1 R^T r for the particles. Unknowns after the particles (free bodies) are in no group.
    void add(Span<const Vec3> r, Span<Vec3> z) const;
    /// Solves Ac m = R^T r for correction().
    void solve(Span<const Vec3> r) const;
    /// R m of particle i.
    Vec3 correction(Index i) const { return groups_ > 0 ? motions_.motion_of(load_, i) : Vec3(Vec3::Zero()); }
    /// R m of an entry of the bodies: 2 b for the velocity of body b, 2 b + 1 for its angular velocity. Only with a coarse level.
    Vec3 of_body(Index entry) const {
        const Real* m = load_.data() + 6 * static_cast<std::size_t>(groups_of_particles()) + 3 * static_cast<std::size_t>(entry);
        return (entry % 2 == 0 ? 1 : 1 / spacing_) * Vec3(m[0], m[1], m[2]);
    }

private:
    int groups_ = 0, steps_ = 0;  ///< steps_: number of steps since the groups were formed
    int bodies_ = 0;              ///< number of groups that are bodies
    Real spacing_ = 1;
    RigidAggregates motions_;
    BlockCholesky factor_;
    mutable std::vector<Real> load_;
};

/// Contribution of some rows of an operator to Ac, as a Sum for each pair of groups that the rows touch. Each thread uses its own object,
/// so no thread waits for another.
template <class Sum>
class GroupSums {
public:
    /// Number of a group in this object, from 0.
    int number(int group) {
        for (std::size_t k = groups_.size(); k-- > 0;)
            if (groups_[k] == group) return static_cast<int>(k);
        groups_.push_back(group);
        place_.resize(groups_.size() * (groups_.size() + 1) / 2, -1);
        return static_cast<int>(groups_.size()) - 1;
    }
    int group(int number) const { return groups_[number]; }
    /// Sum for two groups, given by their numbers. @param row at least column
    Sum& sum(int row, int column) {
        int& place = place_[row * (row + 1) / 2 + column];
        if (place < 0) {
            place = static_cast<int>(sums_.size());
            sums_.push_back({row, column, {}});
        }
        return sums_[place].sum;
    }
    /// Calls f(group of the row, group of the column, sum).
    template <class F>
    void each(const F& f) const {
        for (const Entry& e : sums_) f(groups_[e.row], groups_[e.column], e.sum);
    }

private:
    struct Entry {
        int row, column;
        Sum sum;
    };
    std::vector<int> groups_;
    std::vector<int> place_;  ///< index of (row, column) in sums_; -1: none yet
    std::vector<Entry> sums_;
};

/// Adds a small multiple of the largest entry to the diagonal. A group that is one particle or a straight line has motions that move no
/// particle. The multiple keeps Ac definite.
void keep_definite(SymmetricBlocks& Ac);

/// Sums Ac over all rows, in the order of the tasks.
/// @param rows_of rows_of(task, sums) adds the task's rows @param block block(sum) is the 6x6 block of a sum
template <class Sum, class Rows, class F>
SymmetricBlocks coarse_blocks(int groups, Index tasks, const Rows& rows_of, const F& block) {
    constexpr Index batch = 64;  // number of tasks whose sums are stored at a time
    SymmetricBlocks Ac(groups);
    for (Index from = 0; from < tasks; from += batch) {
        std::vector<GroupSums<Sum>> parts(std::min(batch, tasks - from));
        parallel_tasks(static_cast<Index>(parts.size()), [&](Index k) { rows_of(from + k, parts[k]); });
        for (const GroupSums<Sum>& part : parts) part.each([&](int row, int column, const Sum& sum) { Ac.add(row, column, block(sum)); });
    }
    keep_definite(Ac);
    return Ac;
}

}  // namespace whorl

#pragma once
/// Neighbour search: fills the rows of Pairs.
#include <algorithm>
#include <cmath>

#include "engine/particles/pairs.h"

namespace whorl {

/// Finds all pairs closer than the support radius. Keeps its memory from step to step, so use one object for each purpose.
///
/// Positions are binned in cells whose edges are about half the support along x, and about the support along y and z. If an axis is too
/// long for one bin per cell, the bin is the cell's coordinate modulo the number of bins, so that a stray particle kilometres away costs
/// nothing. Distant cells may then share a bin; the distance test separates their particles.
///
/// A particle with a non-finite position gets no neighbours. Two particles at the same position are neighbours at distance 0. The distance
/// test computes |x_i - x_j|^2, in Real, in the same way for (i, j) and (j, i), so j is in row i if and only if i is in row j.
class NeighbourSearch {
public:
    /// Pairs among x, each in both rows. `pairs` keeps a reference to x.
    /// @param support R [m]; a periodic axis of the domain must be at least 2 R long
    void find(Span<const Vec3> x, Real support, const Domain& domain, Pairs& pairs);
    /// Pairs of each particle of x_own with its neighbours in x_other.
    void find(Span<const Vec3> x_own, Span<const Vec3> x_other, Real support, const Domain& domain, Pairs& pairs);

    /// find() among x in parts, for callers that need each row only once and not all at the same time. Call start() first, then rows() for
    /// any begin and end: rows 0, 1, ... of `part` are then those of x[begin] to x[end - 1].
    void start(Span<const Vec3> x, Real support, const Domain& domain);
    void rows(Span<const Vec3> x, Index begin, Index end, Real support, const Domain& domain, Pairs& part);

    /// find() with a larger radius than the models need, so that narrow() can make the rows of a later step from it.
    void find_wide(Span<const Vec3> x_own, Span<const Vec3> x_other, Real reach, const Domain& domain, Pairs& pairs);
    /// Removes the pairs beyond the support from the result of find_wide(), if the positions of that search are so near to the present ones
    /// that no pair within the support can be missing. The rows are those of find(), in another order. @returns whether it did so;
    /// otherwise nothing is changed
    static bool narrow(Span<const Vec3> x_own, Span<const Vec3> x_other, Real support, const Domain& domain, Pairs& pairs);

    std::size_t capacity_bytes() const;

private:
    static constexpr double most_cells = 1e15;
    static constexpr Index block = 256;  ///< number of particles whose rows a thread makes at a time
    struct Axis {
        double origin = 0, inverse_edge = 0, edge = 0;
        int bins = 1;
        bool wraps = false;  ///< cells share bins modulo `bins`, because the axis is periodic or too long
        /// Limited to integers that a double represents exactly. Beyond that, positions are too coarse for neighbours anyway.
        double cell(double x) const { return std::clamp(std::floor((x - origin) * inverse_edge), -most_cells, most_cells); }
        int bin(double cell) const;
    };
    struct Reach;
    struct Rows;

    void choose_axes(Span<const Vec3> x, Real support, const Domain& domain);
    void fill_bins(Span<const Vec3> x, const Domain& domain);
    /// @param first index of own[0] among the binned particles; -1: the particles `own` are not among them
    void fill_rows(Span<const Vec3> own, Index first, Real support, const Domain& domain, Pairs& pairs);
    template <bool periodic>
    void fill_rows(Span<const Vec3> own, Index first, Real support, const Domain& domain, Pairs& pairs);
    template <class F>
    static void join_blocks(Index n, Pairs& pairs, std::vector<Column<Index>>& memory, const F& make);
    template <bool periodic>
    void append_row(const Vec3& x, Index self, const Reach& reach, Rows& rows) const;

    Axis axis_[3];
    int axes_ = 3;                     ///< axes in use: 2D has one cell along z
    Column<Index> bin_of_;             ///< bin of each particle, -1 if its position is not finite
    Column<Index> start_;              ///< start of each bin in the packed columns
    Column<Real> packed_[3];           ///< positions, sorted by bin
    Column<Index> packed_index_;       ///< their index in the store
    std::vector<Column<Index>> rows_;  ///< rows of each block of a batch
};

}  // namespace whorl

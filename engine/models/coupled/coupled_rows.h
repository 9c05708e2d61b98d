#pragma once
/// Rows of neighbours as the coupled solve wants them: support that grows in thin places, no pairs through the air between two turns of a
/// coil, and a layout that the products run through at the speed of memory.
#include "engine/math/lanes.h"
#include "engine/models/coupled/coupled_options.h"
#include "engine/particles/search.h"

namespace whorl {

/// Moments of a particle's neighbourhood. Lengths in spacings, r = (x_j - x_i)/d.
struct Neighbourhood {
    Mat3 inverse_moment = Mat3::Zero();  ///< M+ = Q diag(pi/s) Q^T of M = sum w r r^T = Q diag(s) Q^T, pi: how far a direction is resolved
    Mat3 resolved = Mat3::Identity();    ///< P = Q diag(pi) Q^T
    Real unresolved = 0;                 ///< k = sum (1 - pi^2): 0 in a volume, 1 in a sheet, 2 in a single file
    Real thin = 0;                       ///< 0 in a thick thread, 1 in a thin one
    Vec3 along = Vec3::Zero();           ///< unit, the thread's direction; zero in a thick one
    Real weights = 0;                    ///< sum w
    Real spread = 0;                     ///< sum w r^2
    Real density = 0;                    ///< n/n0 with the weight of radius `support`, all neighbours
    Vec3 outward = Vec3::Zero();         ///< unit, away from the neighbours' centre
    Real surface = 0;                    ///< |sum w r| / sum w |r|: 0 inside, about 0.4 on a flat surface
};

/// sum w/r^2 r r r r of a row a lane. A symmetric matrix counts as the six numbers (xx, yy, zz, xy, xz, yz); the sum takes one to another.
struct FourthMoment {
    Lanes v[15];  ///< xxxx xxxy xxxz xxyy xxyz xxzz xyyy xyyz xyzz xzzz yyyy yyyz yyzz yzzz zzzz
    /// Of numbers k and l of the six.
    static constexpr int place[6][6] = {{0, 3, 5, 1, 2, 4}, {3, 10, 12, 6, 7, 11}, {5, 12, 14, 8, 9, 13},
                                        {1, 6, 8, 3, 4, 7}, {2, 7, 9, 4, 5, 8},    {4, 11, 13, 7, 8, 12}};
    Lanes of(int k, int l) const { return v[place[k][l]]; }
};

/// As many rows as there are lanes, side by side: pair k of the row in lane l stands at begin + lane_count k + l of the block's columns.
/// Shorter rows, and lanes without a row, end in pairs of weight 0 with themselves.
struct RowSlice {
    std::size_t begin = 0;
    Index width = 0;                ///< pairs of the longest row
    Index row[lane_count] = {};     ///< the row in each lane; a lane without one names the first lane's row
    Index rows = 0;                 ///< lanes that have one
    bool resolved = true;           ///< all directions of all its rows
    SymmetricLanes inverse_moment;  ///< M+
    FourthMoment fourth;
};

/// The rows of `block_size` particles that are near each other in the store. Neighbours are named by their place in `touched`, so that a
/// product gathers each velocity once a block and adds up forces in memory of its own: no thread waits, and the sums' order is fixed.
struct RowBlock {
    Index begin = 0, end = 0;     ///< particles whose rows these are
    std::vector<Index> touched;   ///< the particles named; the first end - begin are the rows' own
    std::size_t place = 0;        ///< where the block's entries begin in arrays over all blocks' touched particles
    std::size_t first_slice = 0;  ///< where its slices begin in arrays over all blocks' slices
    std::vector<RowSlice> slices;
    std::vector<std::size_t> first;  ///< pair of each row
    std::vector<Index> count;        ///< pairs of each row
    Column<Real> x, y, z, w;         ///< r and the weight of each pair
    Column<Index> other;             ///< place of j in touched

    Index size() const { return end - begin; }
    /// Calls f(place in the columns) for each pair of a row.
    template <class F>
    void each_pair(Index row, const F& f) const {
        for (std::size_t e = first[row], last = e + static_cast<std::size_t>(count[row]) * lane_count; e < last; e += lane_count) f(e);
    }
};

/// The pairs of a slice.
struct SliceView {
    const Real *x, *y, *z, *w;
    const Index* other;
    std::size_t width;
    SliceView(const RowBlock& b, const RowSlice& slice)
        : x(b.x.data() + slice.begin), y(b.y.data() + slice.begin), z(b.z.data() + slice.begin), w(b.w.data() + slice.begin),
          other(b.other.data() + slice.begin), width(static_cast<std::size_t>(slice.width)) {}
    /// Calls f(k, r, w, places of j) for the k-th pairs of all lanes.
    template <class F>
    void each(const F& f) const {
        for (std::size_t k = 0, e = 0; k < width; ++k, e += lane_count)
            f(k, Lanes3{lanes_at(x + e), lanes_at(y + e), lanes_at(z + e)}, lanes_at(w + e), other + e);
    }
};

class CoupledRows {
public:
    static constexpr Index block_size = 256;

    /// @param spacing d [m] @param role field::role: pairs of two prescribed particles pass the gate
    void build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing, const CoupledOptions& options);

    Index size() const { return static_cast<Index>(neighbourhood.size()); }
    std::vector<RowBlock> blocks;
    std::vector<Neighbourhood> neighbourhood;  ///< one a particle
    std::size_t pairs = 0;                     ///< in all rows, without padding
    std::size_t slices = 0;                    ///< of all blocks
    Index widest_slice = 0;

    /// The sum of what the blocks hold for particle i, in the order of the blocks; entries: one a touched particle of each block.
    template <class T>
    T gathered(Span<const T> entries, Index i) const {
        T sum = entries[slot_[first_slot_[i]]];
        for (std::size_t k = first_slot_[i] + 1; k < first_slot_[i + 1]; ++k)
            for (std::size_t a = 0; a < sizeof(T) / sizeof(Real); ++a) sum.v[a] += entries[slot_[k]].v[a];
        return sum;
    }
    std::size_t entries() const { return slot_.size(); }
    /// Neighbours within the bridge's reach, at most most_close; gate or not.
    Span<const Index> close(Index i) const {
        const auto at = static_cast<std::size_t>(i);
        return Span<const Index>(close_).subspan(at * most_close, static_cast<std::size_t>(close_count_[at]));
    }

private:
    struct Scratch;
    void build_block(RowBlock& block, Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, const CoupledOptions& options);
    Real find_candidates(Index i, Real spacing, const CoupledOptions& options, Scratch& s) const;
    void find_bridges(Index i, Real h, const CoupledOptions& options, Scratch& s) const;
    Index append_row(RowBlock& block, Index i, Real h, Span<const std::int16_t> role, const CoupledOptions& options, Scratch& s) const;
    static void arrange(RowBlock& block, const Scratch& s);
    void find_moments(RowBlock& block, const CoupledOptions& options);
    void number_slots();

    NeighbourSearch near_search_, far_search_;
    Pairs near_, far_;
    std::vector<Vec3> sparse_;  ///< positions of particles with few neighbours
    static constexpr Index most_close = 48;
    std::vector<Index> close_, close_count_;  ///< neighbours within the bridge's reach, at most most_close each
    unsigned long builds_ = 0;                ///< number of this build among all
    std::vector<Index> sparse_place_;         ///< of each particle in sparse_, -1: enough neighbours
    std::vector<std::size_t> first_slot_, slot_;
};

}  // namespace whorl

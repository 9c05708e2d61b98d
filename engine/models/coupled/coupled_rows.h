#pragma once
/// Rows of neighbours as the coupled solve wants them: support that grows in thin places, no pairs through the air between two turns of a
/// coil, and a layout that the products run through at the speed of memory.
#include "engine/models/coupled/coupled_options.h"
#include "engine/particles/search.h"

namespace whorl {

/// Four numbers in one aligned piece: a vector and a spare.
struct alignas(4 * sizeof(Real)) Vec4 {
    Real v[4];
};

/// Moments of a particle's neighbourhood. Lengths in spacings, r = (x_j - x_i)/d.
struct Neighbourhood {
    Mat3 inverse_moment = Mat3::Zero();  ///< M+ = Q diag(pi/s) Q^T of M = sum w r r^T = Q diag(s) Q^T, pi: how far a direction is resolved
    Mat3 resolved = Mat3::Identity();    ///< P = Q diag(pi) Q^T
    Real unresolved = 0;                 ///< k = sum (1 - pi^2): 0 in a volume, 1 in a sheet, 2 in a single file
    Real thin = 0;                       ///< 0 in a thick thread, 1 in a thin one
    Vec3 along = Vec3::Zero();           ///< unit, the thread's direction; zero in a thick one
    Real spread = 0;                     ///< sum w r^2
    Real density = 0;                    ///< n/n0, kernel of radius `support`, all neighbours
    Vec3 outward = Vec3::Zero();         ///< unit, away from the neighbours' centre
    Real surface = 0;                    ///< |sum w r| / sum w |r|: 0 inside, about 0.4 on a flat surface
};

/// The rows of `block_size` particles that are near each other in the store. Neighbours are named by their place in `touched`, so that a
/// product gathers each velocity once a block and adds up forces in memory of its own: no thread waits, and the sums' order is fixed.
struct RowBlock {
    Index begin = 0, end = 0;        ///< particles whose rows these are
    std::vector<Index> touched;      ///< the particles named; the first end - begin are the rows' own
    std::size_t place = 0;           ///< where the block's entries begin in arrays over all blocks' touched particles
    std::vector<std::size_t> first;  ///< end - begin + 1 offsets; rows are padded to whole vectors with pairs of weight 0
    Column<Real> x, y, z, w;         ///< r and the Wendland weight of each pair
    Column<Index> other;             ///< place of j in touched

    Index size() const { return end - begin; }
    std::size_t row_begin(Index row) const { return first[row]; }
    std::size_t row_end(Index row) const { return first[row + 1]; }
    /// Ends a row: fills the last vector of its pairs, which reach up to `from`, with pairs of no weight.
    void pad(Index row, std::size_t from);
};

class CoupledRows {
public:
    static constexpr Index block_size = 256;
    static constexpr Index lanes = 64 / sizeof(Real);  ///< rows are padded to this many pairs

    /// @param spacing d [m] @param role field::role: pairs of two prescribed particles pass the gate
    void build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing, const CoupledOptions& options);

    Index size() const { return static_cast<Index>(neighbourhood.size()); }
    std::vector<RowBlock> blocks;
    std::vector<Neighbourhood> neighbourhood;  ///< one a particle
    std::size_t pairs = 0;                     ///< in all rows, without padding
    std::size_t longest_row = 0;               ///< padded

    /// y_i = sum of what the blocks hold for particle i, in the order of the blocks; entries: one a touched particle of each block.
    template <class T, class F>
    void gather(Span<const T> entries, const F& f) const {
        parallel_for(size(), [&](Index i) {
            T sum = entries[slot_[first_slot_[i]]];
            for (std::size_t k = first_slot_[i] + 1; k < first_slot_[i + 1]; ++k)
                for (std::size_t a = 0; a < sizeof(T) / sizeof(Real); ++a) sum.v[a] += entries[slot_[k]].v[a];
            f(i, sum);
        });
    }
    std::size_t entries() const { return slot_.size(); }

private:
    struct Scratch;
    void build_block(RowBlock& block, Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, const CoupledOptions& options);
    Real find_candidates(Index i, Real spacing, const CoupledOptions& options, Scratch& s) const;
    void find_bridges(Index i, Real h, const CoupledOptions& options, Scratch& s) const;
    std::size_t append_row(RowBlock& block, Index i, Real h, Span<const std::int16_t> role, const CoupledOptions& options,
                           Scratch& s) const;
    void number_slots();

    NeighbourSearch near_search_, far_search_;
    Pairs near_, far_;
    std::vector<Vec3> sparse_;  ///< positions of particles with few neighbours
    static constexpr Index most_close = 48;
    std::vector<Index> close_, close_count_;  ///< neighbours within the bridge's reach, at most most_close each
    unsigned long builds_ = 0;                ///< number of this build among all
    std::vector<Index> sparse_place_;         ///< of each particle in sparse_, -1: enough neighbours
    std::vector<std::size_t> first_slot_, slot_;
    std::vector<std::size_t> row_pairs_;  ///< of each block
};

}  // namespace whorl

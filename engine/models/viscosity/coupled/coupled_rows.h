#pragma once
/// Rows of neighbours for the coupled solve. The support grows where particles have few neighbours. There are no pairs through the air
/// between two turns of a coil. The layout makes products as fast as the memory allows.
#include <array>

#include "engine/geometry/solids.h"
#include "engine/math/lanes.h"
#include "engine/models/viscosity/coupled/coupled_options.h"
#include "engine/particles/search.h"

namespace whorl {

/// Properties of a particle's neighbourhood. Lengths in spacings d, r = (x_j - x_i)/d, w: weight of the pair (docs/physics.md 5).
struct Neighbourhood {
    Real unresolved = 0;  ///< k = sum (1 - pi^2) over the three directions, pi: degree to which a direction is resolved. 0 in a volume, 1
                          ///< in a sheet, 2 in a single file
    Real thin = 0;        ///< 0 in a thick thread, 1 in a thin thread
    Real weights = 0;     ///< sum w
    Real spread = 0;      ///< sum w r^2
    Real density = 0;     ///< n/n0: sum of the weights of radius `support`, divided by its value on a lattice; solids count as fluid
    Real volume = 1;      ///< (volume of the fluid whose strain the row represents)/V; this volume ends at a wall that holds the particle
    Vec3 outward = Vec3::Zero();   ///< unit vector away from the neighbours' centre
    Real surface = 0;              ///< |sum w r| / sum w |r|: 0 inside, about 0.4 on a flat surface
    std::int32_t directions = -1;  ///< index in RowBlock::directions; -1: all directions are resolved, and no thread is thin
};

/// Additional data of a neighbourhood in which not all directions are resolved, or which is a thin thread.
struct Directions {
    Mat3 resolved = Mat3::Identity();  ///< P = Q diag(pi) Q^T
    Vec3 along = Vec3::Zero();         ///< direction of a thin thread, unit vector; zero in a thick one
};

/// Fourth moment sum w/r^2 r r r r of one row per lane. It maps a symmetric matrix, with the six entries (xx, yy, zz, xy, xz, yz), to
/// another.
struct FourthMoment {
    Lanes v[15];  ///< xxxx xxxy xxxz xxyy xxyz xxzz xyyy xyyz xyzz xzzz yyyy yyyz yyzz yzzz zzzz
    /// Index in v of the entry for components k and l of the six.
    static constexpr int place[6][6] = {{0, 3, 5, 1, 2, 4}, {3, 10, 12, 6, 7, 11}, {5, 12, 14, 8, 9, 13},
                                        {1, 6, 8, 3, 4, 7}, {2, 7, 9, 4, 5, 8},    {4, 11, 13, 7, 8, 12}};
    Lanes of(int k, int l) const { return v[place[k][l]]; }
};

/// Mean velocity [m/s], over a step of dt [s], of the point of the solid that is at x at the start of the step. dt < 0: of the point that
/// is at x at the end of the step.
inline Vec3 velocity_over(const Solid& solid, const Vec3& x, Real dt) { return solid.velocity_at(x + dt / 2 * solid.velocity_at(x)); }

/// Neighbour of a particle that a wall holds: the nearest point of the wall, which moves with the wall (docs/physics.md 5).
struct WallPoint {
    Vec3 position, velocity;  ///< position on the surface [m]; mean velocity over this step, along a straight line [m/s]
    Vec3 normal;              ///< into the fluid
    Index row = 0;            ///< row of the particle in its block
    Index solid = 0;
    /// Number of the free body among all, whose velocity is an unknown of the solve; -1: the velocity is known
    std::int32_t body = -1;
    Vec3 arm = Vec3::Zero();  ///< vector from the body's centre to the point, the mean over this step [m]
    Real weight = 0;
    Mat3 lateral = Mat3::Zero();  ///< contribution to M along the wall
    /// Share s of the tangential velocity of the particle relative to the wall that the fluid between them has, h/(h + b) with the slip
    /// length b: the pair's velocity is C (u_wall - u_i), C = n n^T + s (1 - n n^T). 1: the fluid sticks, 0: it slides freely
    Real stick = 1;
    Real friction = 0;  ///< b/(h + b)^2 times the covered part of the wall: friction per area over mu (u_wall - u_i)_t [1/m]

    bool slides() const { return stick < 1; }
    /// Velocity of the point. @param bodies velocity and angular velocity of each free body [m/s, 1/s]
    Vec3 carried_by(Span<const Vec3> bodies) const {
        const Vec3* of = &bodies[2 * static_cast<std::size_t>(body)];
        return of[0] + of[1].cross(arm);
    }
    /// (1 - C) v
    Vec3 slipping(const Vec3& v) const { return (1 - stick) * (v - normal * normal.dot(v)); }
};

/// Rows of lane_count particles, interleaved: pair k of the row in lane l is at begin + lane_count k + l of the block's `other`. Shorter
/// rows, and lanes without a row, are filled with pairs of a particle with itself, which have the weight 0. Pairs with walls come last.
struct RowSlice {
    std::size_t begin = 0;
    Index width = 0;             ///< number of pairs of the longest row plus `walls`
    Index walls = 0;             ///< largest number of pairs with walls in a row
    std::size_t first_wall = 0;  ///< index of their weights in RowBlock::wall_weight
    Index plain() const { return width - walls; }
    Index rows = 0;                      ///< lanes that have a row
    std::uint16_t row[lane_count] = {};  ///< row in each lane; lanes without a row contain that of the first lane
    bool resolved = true;                ///< whether all directions are resolved in all rows
    Lanes of_h2{};                       ///< 1/h^2, with h the radius of the weight in spacings
    SymmetricLanes inverse_moment;       ///< M+ = Q diag(pi/s) Q^T of M = sum w r r^T = Q diag(s) Q^T
    FourthMoment fourth;
};

/// The rows of `block_size` particles that are near each other in memory. Pairs refer to neighbours by their index in `touched`, so a
/// product gathers each velocity once per block and adds forces in the block's own memory. Thus no thread waits for another, and sums have
/// a fixed order. Only this index is stored per pair. r and the weight are computed from the positions, because reading r and the weight
/// would need more bytes.
struct RowBlock {
    using LocalIndex = std::uint16_t;
    Index begin = 0, end = 0;     ///< range of the particles that the rows belong to
    std::vector<Index> touched;   ///< particles that the pairs refer to; the first end - begin are the rows' own
    std::size_t place = 0;        ///< start of the block's entries in arrays over all blocks' touched particles
    std::size_t first_slice = 0;  ///< start of the block's slices in arrays over all blocks' slices
    std::vector<RowSlice> slices;
    std::vector<std::uint16_t> lane;   ///< lane of each row, counted through all slices
    std::vector<std::uint16_t> count;  ///< number of pairs of each row, without walls
    std::vector<Directions> directions;
    Column<LocalIndex> other;      ///< index of j in `touched`; walls have the indices that follow
    std::vector<WallPoint> walls;  ///< by row
    std::vector<Lanes> wall_weight;

    Index size() const { return end - begin; }
    std::size_t entries() const { return touched.size() + walls.size(); }  ///< number of indices that pairs use
    const RowSlice& slice_of(Index row) const { return slices[lane[row] / lane_count]; }
    Index lane_in_slice(Index row) const { return lane[row] % lane_count; }
    /// Calls f(index in touched) for each pair of a row with a particle, or for every `step`-th.
    template <class F>
    void each_pair(Index row, const F& f, Index step = 1) const {
        const LocalIndex* at = other.data() + slice_of(row).begin + lane_in_slice(row);
        for (Index k = 0; k < count[row]; k += step) f(at[k * lane_count]);
    }
    /// P of the particle with neighbourhood n.
    Mat3 resolved(const Neighbourhood& n) const { return n.directions < 0 ? Mat3(Mat3::Identity()) : directions[n.directions].resolved; }
    Vec3 along(const Neighbourhood& n) const { return n.directions < 0 ? Vec3(Vec3::Zero()) : directions[n.directions].along; }
};

/// One pair of each row in a slice.
struct PairLanes {
    Lanes3 r, v;                        ///< v: vector stored with the position of j, minus the one stored with that of i
    Lanes r2, w;                        ///< r2: never 0
    const RowBlock::LocalIndex* other;  ///< indices of j in `touched`
};

/// Lengths of the periodic axes in spacings; 0 for other axes.
struct PairPeriod {
    bool any = false;
    Vec3 length = Vec3::Zero(), of_length = Vec3::Zero();  ///< of_length: 1/length

    [[gnu::always_inline]] Lanes3 shortest(const Lanes3& r) const { return any ? Lanes3{along(r.x, 0), along(r.y, 1), along(r.z, 2)} : r; }

private:
    Lanes along(Lanes r, int axis) const { return r - length[axis] * rounded(r * of_length[axis]); }
};

/// The pairs of a slice. @tparam with whether a vector is stored with each position (CoupledRows::positions)
template <bool with>
class SliceView {
public:
    SliceView(const PairPeriod& period, const RowBlock& b, const RowSlice& slice, const Vec4* at)
        : period_(period), slice_(slice), at_(at), other_(b.other.data() + slice.begin),
          wall_weight_(b.wall_weight.data() + slice.first_wall) {}
    /// Calls f(k, pair) for the k-th pairs of all lanes.
    template <class F>
    [[gnu::always_inline]] void each(const F& f) const {
        each_plain(f);
        each_wall(f);
    }
    /// Pairs with particles only.
    template <class F>
    [[gnu::always_inline]] void each_plain(const F& f) const {
        const TwoLanes3 own = taken(slice_.row);
        const Lanes one = lanes_of(1), none{};
        for (Index k = 0; k < slice_.plain(); ++k) {
            PairLanes p = pair(own, k);
            const Lanes q = one - p.r2 * slice_.of_h2;
            p.w = p.r2 > 2 * coincident ? q * q * q : none;  // a pair with itself has no weight
            f(static_cast<std::size_t>(k), p);
        }
    }
    /// Pairs with walls only.
    template <class F>
    void each_wall(const F& f) const {
        if (slice_.walls == 0) return;
        const TwoLanes3 own = taken(slice_.row);
        for (Index k = slice_.plain(); k < slice_.width; ++k) {
            PairLanes p = pair(own, k);
            p.w = wall_weight_[k - slice_.plain()];
            f(static_cast<std::size_t>(k), p);
        }
    }

private:
    [[gnu::always_inline]] PairLanes pair(const TwoLanes3& own, Index k) const {
        PairLanes p;
        p.other = other_ + static_cast<std::size_t>(k) * lane_count;
        const TwoLanes3 j = taken(p.other);
        p.r = period_.shortest(j.first - own.first);
        if constexpr (with) p.v = j.second - own.second;
        p.r2 = dot(p.r, p.r) + coincident;
        return p;
    }
    [[gnu::always_inline]] TwoLanes3 taken(const RowBlock::LocalIndex* place) const {
        if constexpr (with) return gather_two(at_, place);
        else return {gather(at_, place), {}};
    }
    static constexpr Real coincident = Real(1e-12);  ///< r^2 up to which two particles coincide and are not a pair

    const PairPeriod& period_;
    const RowSlice& slice_;
    const Vec4* at_;
    const RowBlock::LocalIndex* other_;
    const Lanes* wall_weight_;
};

/// Solids that become neighbours of the particles that touch them.
struct TouchedSolids {
    const Solids& solids;
    Real dt = 0;              ///< s, for the solids' velocities
    Span<std::int32_t> held;  ///< field::held
    Span<Vec3> slip;          ///< field::contact_normal
};

class CoupledRows {
public:
    static constexpr Index block_size = 256;

    /// @param spacing d [m] @param role field::role; the gate does not apply to pairs of two prescribed particles
    void build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing, const CoupledOptions& options,
               const TouchedSolids& solids = {{}, 0, {}, {}});

    Index size() const { return static_cast<Index>(neighbourhood.size()); }
    int dimensions() const { return dimensions_; }
    const RowBlock& block_of(Index i) const { return blocks[i / block_size]; }
    std::vector<RowBlock> blocks;
    std::vector<Neighbourhood> neighbourhood;  ///< one per particle
    Column<Real> nearest_solid;                ///< distance of each free particle to any solid [m]; empty: there are no solids
    std::size_t pairs = 0;                     ///< number of pairs in all rows, without padding
    std::size_t slices = 0;                    ///< slices in all blocks
    std::size_t walls = 0;                     ///< number of pairs with walls
    bool any_slip = false;                     ///< whether fluid slides on any of these walls
    Index widest_slice = 0;

    /// Position of the particle when the rows were built [m].
    Vec3 position(Index i) const { return Vec3(x_[i].v[0], x_[i].v[1], x_[i].v[2]); }
    Vec3 in_spacings(const Vec3& length) const { return of_spacing_ * length; }
    /// Positions of the particles that the block touches, in spacings relative to the block's first particle. They are in memory of the
    /// calling thread, valid until its next call. @param u vectors to store with the positions; entries after those of the particles are
    /// velocity and angular velocity of each free body @param moving true: walls have their velocities; false: walls are at rest
    const Vec4* positions(const RowBlock& block) const;
    const Vec4* positions(const RowBlock& block, Span<const Vec3> u, bool moving) const;
    SliceView<false> pairs_of(const RowBlock& block, const RowSlice& slice, const Vec4* at) const { return {period_, block, slice, at}; }
    /// @param at from positions() with u
    SliceView<true> pairs_with(const RowBlock& block, const RowSlice& slice, const Vec4* at) const { return {period_, block, slice, at}; }
    /// M+ of particle i.
    Mat3 inverse_moment(Index i) const {
        const RowBlock& block = block_of(i);
        return lane_of(block.slice_of(i - block.begin).inverse_moment, block.lane_in_slice(i - block.begin));
    }
    Mat3 resolved(Index i) const { return block_of(i).resolved(neighbourhood[i]); }

    /// Sum of the blocks' values for particle i, in the order of the blocks. @param entries `pieces` values per touched particle of each
    /// block
    template <std::size_t pieces = 1>
    std::array<Vec4, pieces> gathered(Span<const Vec4> entries, Index i) const {
        std::array<Vec4, pieces> sum{};
        for (std::uint32_t k = first_slot_[i]; k < first_slot_[i + 1]; ++k)
            for (std::size_t a = 0; a < pieces; ++a) quad(sum[a]) += quad(entries[pieces * slot_[k] + a]);
        return sum;
    }
    std::size_t entries() const { return entries_; }

private:
    struct Scratch;
    struct Found;
    struct Walls;
    void build_block(RowBlock& block, const Found& found, Span<const std::int16_t> role, const CoupledOptions& options, const Walls& walls);
    void find_moments(RowBlock& block, const CoupledOptions& options);
    void number_slots();

    template <bool with>
    const Vec4* take(const RowBlock& block, Span<const Vec3> u, bool moving) const;

    PairPeriod period_;
    int dimensions_ = 3;
    Real of_spacing_ = 0;
    Column<Vec4> x_;
    unsigned long builds_ = 0;  ///< number of this build, counted over all CoupledRows
    std::vector<std::uint32_t> first_slot_, slot_;
    std::size_t entries_ = 0;
};

}  // namespace whorl

#include "engine/models/viscosity/coupled/coupled_rows.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "engine/core/parallel.h"
#include "engine/math/inverse_in.h"
#include "engine/math/kernel.h"
#include "engine/models/viscosity/strain/moment.h"

namespace whorl {
namespace {

/// (1 - q^2)^3 as a function of q^2. A Wendland kernel with the same second moment has 1.17 times the radius and 1.6 times the pairs.
Real weight_at(Real q2) {
    const Real p = std::max(Real(0), 1 - q2);
    return p * p * p;
}

/// Properties of M = sum w r r^T that follow from the eigenvalues of M.
struct MomentShape {
    Mat3 inverse_moment = Mat3::Zero();
    Directions directions;
    bool volume = false;  ///< all directions are resolved, and no thread is thin
};

MomentShape shape_of(const Mat3& M, const CoupledOptions& o, int dimensions, Neighbourhood& n) {
    MomentShape shape;
    const Mat3d wide = M.cast<double>();
    Eigen::SelfAdjointEigenSolver<Mat3d> axes;
    axes.computeDirect(wide, Eigen::EigenvaluesOnly);
    const Vec3d s = axes.eigenvalues();
    if (!(s[2] > 0)) return shape;
    if (dimensions == 3) n.thin = static_cast<Real>(smooth_step((o.thin_below - s[1] / s[2]) / (o.thin_below - o.thin_at)));
    const bool whole = dimensions == 3 ? resolves_all(s) : s[1] >= resolved_above * s[2];
    if (whole) shape.inverse_moment = inverse_in(dimensions, wide).cast<Real>();
    shape.volume = whole && n.thin == 0;
    if (shape.volume) return shape;
    axes.computeDirect(wide);
    if (n.thin > 0) shape.directions.along = axes.eigenvectors().col(2).cast<Real>();
    if (whole) return shape;
    const Moment moment = invert_moment(axes.eigenvalues(), axes.eigenvectors(), dimensions);
    shape.inverse_moment = moment.inverse.cast<Real>();
    shape.directions.resolved = moment.resolved.cast<Real>();
    n.unresolved = static_cast<Real>(moment.unresolved);
    return shape;
}

/// Adds the walls' parts along the walls to M. Walls resolve directions, but do not change whether the fluid is a thin thread. @param M sum
/// over all pairs of the row, also with walls
void add_walls(const RowBlock& block, Index row, Mat3 M, const CoupledOptions& o, int dimensions, Neighbourhood& n, MomentShape& shape) {
    bool any = false;
    for (const WallPoint& wall : block.walls)
        if (wall.row == row) any = true, M += wall.lateral;
    if (!any) return;
    const Vec3 along = shape.directions.along;
    const Real thin = n.thin;
    n.unresolved = 0;
    shape = shape_of(M, o, dimensions, n);
    shape.directions.along = along;
    n.thin = thin;
    shape.volume = n.unresolved == 0 && thin == 0;
}

}  // namespace

/// Result of the neighbour search, input of the rows.
struct CoupledRows::Found {
    static constexpr Index most_close = 48;
    struct CloseRow {
        std::uint16_t first = 0, count = 0;  ///< range in the list of its block
    };
    Real spacing = 0;
    int dimensions = 3;
    static constexpr Index part_size = 32 * block_size;
    std::vector<Pairs> near;          ///< neighbours within the usual support: the rows of part_size particles each
    Pairs far;                        ///< neighbours of sparse particles within the widest support
    std::vector<Vec3> sparse;         ///< positions of particles with few neighbours
    std::vector<Index> sparse_place;  ///< index of each particle in `sparse`; -1: the particle has enough neighbours
    std::vector<CloseRow> close_row;
    std::vector<std::vector<Index>> close_list;  ///< by block

    /// Neighbours closer than `bridge`, at most most_close.
    Span<const Index> close(Index i) const {
        const CloseRow row = close_row[i];
        return Span<const Index>(close_list[i / block_size]).subspan(row.first, row.count);
    }
    const Pairs& near_of(Index i) const { return near[i / part_size]; }
    void search(Span<const Vec3> x, const Domain& domain, const CoupledOptions& options);
    void list_close(Real reach);
};

/// The solids near the particles.
struct CoupledRows::Walls {
    const Solids& solids;
    int dimensions = 3;
    Real dt = 0;
    Span<std::int32_t> held;
    Span<Vec3> slip;
    Column<Real>& nearest;                 ///< CoupledRows::nearest_solid
    Column<Real> height{};                 ///< distance from the nearest no-slip solid [m]
    std::vector<std::int32_t> touching{};  ///< field::held by each particle's own distance, without its neighbours

    void find(Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, const CoupledOptions& o);
    /// Writes field::held.
    void hold(Index i, const Found& found, const CoupledOptions& o) const;
};

/// Candidates of one row: all particles within the widest support in use. Lengths in spacings.
struct CoupledRows::Scratch {
    static constexpr Index most_walls = 6;  ///< limit per particle
    Column<Real> x, y, z, r2, w;            ///< w: weight; 0 if the candidate is not a neighbour
    std::vector<Index> index;
    std::vector<Real> order;
    std::vector<std::size_t> bridges;
    std::vector<RowBlock::LocalIndex> row_other;  ///< pairs of the block's rows, row after row
    std::vector<std::size_t> row_first;
    std::vector<Real> row_h;
    std::vector<Index> touched;
    std::vector<std::int32_t> place;  ///< index of each particle in `touched`, -1: not in the list; all are -1 between two blocks
    std::vector<Index> reached;       ///< by particle j: the last i such that j is a close neighbour of a close neighbour of i

    unsigned long build = 0;  ///< build for which `reached` was cleared

    /// Index of j in `touched`; -1 if the block is full, which happens only if fluid is compressed forty-fold.
    std::int32_t place_of(Index j) {
        if (place[j] < 0 && touched.size() + most_walls * block_size <= std::numeric_limits<RowBlock::LocalIndex>::max()) {
            place[j] = static_cast<std::int32_t>(touched.size());
            touched.push_back(j);
        }
        return place[j];
    }
    Real find_candidates(Index i, const Found& found, const CoupledOptions& options);
    void find_bridges(Index i, Real h, const Found& found, const CoupledOptions& options);
    void append_row(Index i, Real h, Span<const std::int16_t> role, const CoupledOptions& options);
    void find_walls(RowBlock& block, Index i, const Vec3& at, Real h, Real d, const Walls& walls, const CoupledOptions& options,
                    Neighbourhood& n) const;
    Real uncovered(const Vec3& normal, int dimensions) const;
    void arrange(RowBlock& block) const;
    void resize(std::size_t n) {
        for (Column<Real>* c : {&x, &y, &z, &r2, &w}) c->resize(n);
        index.resize(n);
    }
    /// Sets the candidates to the neighbours of i, r = (x_j - x_i)/d. @param itself neighbour to omit, i itself; -1: none
    void take(const Pairs& pairs, Index i, Real inverse_spacing, Index itself) {
        resize(static_cast<std::size_t>(pairs.count(i)));
        Index end = 0;
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real* const to[4] = {x.data() + end, y.data() + end, z.data() + end, r2.data() + end};
            for (int a = 0; a < 3; ++a)
                for (Index l = 0; l < group.count; ++l) to[a][l] = group.r[a][l] * -inverse_spacing;
            for (Index l = 0; l < group.count; ++l) to[3][l] = to[0][l] * to[0][l] + to[1][l] * to[1][l] + to[2][l] * to[2][l];
            std::copy(group.other, group.other + group.count, index.begin() + end);
            end += group.count;
        });
        const auto self = std::find(index.begin(), index.end(), itself);
        if (self == index.end()) return;
        const auto at = static_cast<std::size_t>(self - index.begin()), last = index.size() - 1;
        for (Column<Real>* c : {&x, &y, &z, &r2}) (*c)[at] = (*c)[last];
        index[at] = index[last];
        resize(last);
    }
    /// Whether a candidate is closer than `reach` to both the particle and candidate k. `bridges` lists those close to the particle.
    bool bridged(std::size_t k, Real reach2) const {
        for (const std::size_t l : bridges) {
            const Real dx = x[l] - x[k], dy = y[l] - y[k], dz = z[l] - z[k];
            if (l != k && dx * dx + dy * dy + dz * dz < reach2) return true;
        }
        return false;
    }
};

namespace {

/// n0: sum of the weights of radius h on a lattice. The integral of the weight is 0.5 % larger in 2D.
Real lattice_sum(int dimensions, Real h) {
    Real sum = 0;
    each_lattice_point(dimensions, static_cast<int>(h),
                       [&](int a, int b, int c) { sum += weight_at(static_cast<Real>(a * a + b * b + c * c) / (h * h)); });
    return sum;
}

/// Computes the weights w of all candidates, 0 beyond h. @returns n, the sum of the weights of radius h0
Real weigh(Index count, const Real* __restrict r2, Real h0, Real h, Real* __restrict w) {
    const Real of_h0 = 1 / (h0 * h0), of_h = 1 / (h * h);
    Real density = 1;
    for (Index k = 0; k < count; ++k) {
        density += weight_at(r2[k] * of_h0);
        w[k] = r2[k] > Real(1e-12) ? weight_at(r2[k] * of_h) : 0;
    }
    return density;
}

}  // namespace

void CoupledRows::Found::search(Span<const Vec3> x, const Domain& domain, const CoupledOptions& options) {
    NeighbourSearch search;
    const auto n = static_cast<Index>(x.size());
    const Real support = static_cast<Real>(options.support) * spacing;
    search.start(x, support, domain);
    for (Index begin = 0; begin < n; begin += part_size)
        search.rows(x, begin, std::min(n, begin + part_size), support, domain, near.emplace_back());
    // h is the distance of the 16th neighbour, within [support, widest_support], so only particles with fewer than 16 neighbours in
    // `support` need a wider search.
    sparse_place.assign(x.size(), -1);
    for (Index i = 0; i < n; ++i)
        if (near_of(i).count(i % part_size) < options.enough(dimensions)) {
            sparse_place[i] = static_cast<Index>(sparse.size());
            sparse.push_back(x[i]);
        }
    if (!sparse.empty()) search.find(sparse, x, static_cast<Real>(options.widest()) * spacing, domain, far);
}

void CoupledRows::Found::list_close(Real reach) {
    const auto n = static_cast<Index>(sparse_place.size());
    close_row.resize(n);
    close_list.resize((n + block_size - 1) / block_size);
    parallel_blocks(n, block_size, [&](Index begin, Index end) {
        Index memory[block_size * most_close], total = 0;
        for (Index i = begin; i < end; ++i) {
            Index listed = 0, *const list = memory + total;
            near_of(i).groups_of(i % part_size, [&](const Pairs::Group& group) {
                for (Index l = 0; l < group.count && listed < most_close; ++l) {
                    list[listed] = group.other[l];
                    listed += group.distance[l] < reach;
                }
            });
            close_row[i] = {static_cast<std::uint16_t>(total), static_cast<std::uint16_t>(listed)};
            total += listed;
        }
        close_list[begin / block_size].assign(memory, memory + total);
    });
}

void CoupledRows::Walls::find(Span<const Vec3> x, Span<const std::int16_t> role, Real d, const CoupledOptions& o) {
    nearest.resize(solids.all.empty() ? 0 : x.size());
    if (nearest.empty()) return;
    height.resize(x.size()), touching.resize(x.size());
    parallel_for(static_cast<Index>(x.size()), [&](Index i) {
        nearest[i] = height[i] = std::numeric_limits<Real>::infinity();
        if (role[i] != 0) return;
        for (const Solid& solid : solids.all) {
            const Real distance = solid.distance(x[i]);
            nearest[i] = std::min(nearest[i], distance);
            if (solid.sticks()) height[i] = std::min(height[i], distance);
            else if (held[i] == 0 && distance < static_cast<Real>(o.wall_reach) * d) slip[i] = solid.normal(x[i]);
        }
        const Real reach = static_cast<Real>(held[i] < 0 ? o.wall_touch : o.wall_reach) * d;
        touching[i] = height[i] < reach ? 1 : -1;
    });
}

void CoupledRows::Walls::hold(Index i, const Found& found, const CoupledOptions& o) const {
    held[i] = touching[i];
    const Real touch = static_cast<Real>(o.wall_touch) * found.spacing, spread = static_cast<Real>(o.wall_spread) * found.spacing;
    if (held[i] < 0 && height[i] < spread)
        for (const Index j : found.close(i))
            if (touching[j] > 0 && height[j] < touch) held[i] = 1;
}

void CoupledRows::build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing,
                        const CoupledOptions& options, const Solids& solids, Real dt, Span<std::int32_t> held, Span<Vec3> slip) {
    const auto n = static_cast<Index>(x.size());
    static std::atomic<unsigned long> count{0};
    builds_ = ++count;
    of_spacing_ = 1 / spacing;
    period_ = {domain.any_periodic(), domain.period() * of_spacing_};
    for (int a = 0; a < 3; ++a) period_.of_length[a] = period_.length[a] > 0 ? 1 / period_.length[a] : 0;
    x_.resize(x.size());
    parallel_for(n, [&](Index i) { x_[i] = with_spare(x[i]); });
    blocks.clear();  // before the search, which needs as much memory
    std::vector<std::uint32_t>().swap(slot_);
    Found found;
    found.spacing = spacing;
    found.dimensions = dimensions_ = domain.dimensions();
    found.search(x, domain, options);
    found.list_close(static_cast<Real>(options.bridge) * spacing);

    Walls near_walls{solids, dimensions_, dt, held, slip, nearest_solid};
    near_walls.find(x, role, spacing, options);
    neighbourhood.assign(x.size(), {});
    blocks.resize((n + block_size - 1) / block_size);
    for (Index from = 0; from < n; from += Found::part_size) {
        parallel_blocks(std::min(n - from, Found::part_size), block_size, [&](Index begin, Index end) {
            RowBlock& block = blocks[(from + begin) / block_size];
            block.begin = from + begin;
            block.end = from + end;
            build_block(block, found, role, options, near_walls);
        });
        found.near[from / Found::part_size] = {};  // frees the lists that rows replace
    }
    number_slots();
    pairs = slices = walls = 0;
    any_slip = false;
    widest_slice = 0;
    for (RowBlock& block : blocks) {
        block.first_slice = slices;
        slices += block.slices.size();
        walls += block.walls.size();
        for (const WallPoint& wall : block.walls) any_slip |= wall.slides();
        for (const Index in_row : block.count) pairs += static_cast<std::size_t>(in_row);
        for (const RowSlice& slice : block.slices) widest_slice = std::max(widest_slice, slice.width);
    }
}

void CoupledRows::build_block(RowBlock& block, const Found& found, Span<const std::int16_t> role, const CoupledOptions& o,
                              const Walls& near_walls) {
    thread_local Scratch s;
    s.place.resize(x_.size(), -1);
    if (s.reached.size() != x_.size() || s.build != builds_) s.reached.assign(x_.size(), -1), s.build = builds_;
    s.touched.clear(), s.row_other.clear(), s.row_h.clear();
    s.row_first.assign(1, 0);
    block.walls.clear();
    for (Index i = block.begin; i < block.end; ++i) s.place_of(i);
    const Real support = static_cast<Real>(o.support), at_rest = lattice_sum(dimensions_, support);
    for (Index i = block.begin; i < block.end; ++i) {
        const Real h = s.find_candidates(i, found, o);
        neighbourhood[i].density = weigh(static_cast<Index>(s.index.size()), s.r2.data(), support, h, s.w.data()) / at_rest;
        s.find_bridges(i, h, found, o);
        s.append_row(i, h, role, o);
        if (!near_walls.nearest.empty() && near_walls.nearest[i] < static_cast<Real>(o.support) * found.spacing) {
            near_walls.hold(i, found, o);
            s.find_walls(block, i, position(i), h, found.spacing, near_walls, o, neighbourhood[i]);
        } else if (!near_walls.nearest.empty()) near_walls.held[i] = -1;
        s.row_first.push_back(s.row_other.size());
        s.row_h.push_back(h);
    }
    for (Index j : s.touched) s.place[j] = -1;
    block.touched = s.touched;
    s.arrange(block);
    find_moments(block, o);
}

/// @returns the kernel radius in spacings: the usual support, or the distance of the 16th neighbour if the usual support contains fewer
Real CoupledRows::Scratch::find_candidates(Index i, const Found& found, const CoupledOptions& o) {
    const Real inverse_spacing = 1 / found.spacing;
    const Index sparse = found.sparse_place[i];
    const Real usual = static_cast<Real>(o.support), widest = static_cast<Real>(o.widest());
    if (sparse < 0) {
        take(found.near_of(i), i % Found::part_size, inverse_spacing, -1);
        return usual;
    }
    take(found.far, sparse, inverse_spacing, i);
    const int enough_here = o.enough(found.dimensions);
    if (static_cast<int>(index.size()) < enough_here) return widest;
    order.assign(r2.begin(), r2.end());
    const auto enough = order.begin() + (enough_here - 1);
    std::nth_element(order.begin(), enough, order.end());
    return std::clamp(std::sqrt(*enough), usual, widest);
}

/// Finds the particles that bridge pairs longer than the gate. With the usual support, marks in `reached` the close neighbours of the close
/// neighbours of i.
void CoupledRows::Scratch::find_bridges(Index i, Real h, const Found& found, const CoupledOptions& o) {
    const Real usual = static_cast<Real>(o.support);
    if (h == usual) {
        for (const Index bridge : found.close(i))
            for (const Index j : found.close(bridge)) reached[j] = i;
        return;
    }
    const Real reach = static_cast<Real>(o.bridge) * (h / usual);
    bridges.clear();
    for (std::size_t k = 0; k < index.size(); ++k)
        if (r2[k] < reach * reach) bridges.push_back(k);
}

/// Appends to the row the candidates that the gate admits.
void CoupledRows::Scratch::append_row(Index i, Real h, Span<const std::int16_t> role, const CoupledOptions& o) {
    const Real usual = static_cast<Real>(o.support), scale = h / usual;
    const Real gate = static_cast<Real>(o.gate) * scale, reach = static_cast<Real>(o.bridge) * scale;
    for (std::size_t k = 0; k < index.size(); ++k) {
        if (w[k] == 0) continue;
        const Index j = index[k];
        if (r2[k] > gate * gate && !(role[i] != 0 && role[j] != 0)) {
            const bool counts = h == usual ? reached[j] == i : bridged(k, reach * reach);
            if (!counts) w[k] = 0;
            if (!counts) continue;
        }
        if (const std::int32_t at = place_of(j); at >= 0) row_other.push_back(static_cast<RowBlock::LocalIndex>(at));
    }
}

namespace {

/// Fraction of the integral of the weight of radius 1 that lies beyond a plane at distance q.
Real beyond(int dimensions, Real q) {
    if (q >= 1) return 0;
    if (dimensions == 2) {  // 128/(35 pi) times the integral of (1 - t^2)^(7/2) = cos^8 a da, t = sin a
        const double a = std::asin(static_cast<double>(q));
        const double waves = 28 * std::sin(2 * a) + 7 * std::sin(4 * a) + 4 * std::sin(6 * a) / 3 + std::sin(8 * a) / 8;
        return static_cast<Real>(0.5 - (a + waves / 35) / std::numbers::pi);
    }
    const Real t = q * q;
    return Real(0.5) - Real(315.0 / 256) * q * (1 - t * (Real(4.0 / 3) - t * (Real(1.2) - t * (Real(4.0 / 7) - t / 9))));
}

/// Fraction of the integral of the weight that lies in a solid, which may be thin. @param h distance of the solid's surface from x [m]
/// @param R radius of the weight [m]
Real filled(int dimensions, const Solid& solid, const Vec3& x, const Vec3& normal, Real h, Real R) {
    h = std::max(h, Real(0));
    if (!(h < R)) return 0;
    if (solid.distance(x - R * normal) < 0) return beyond(dimensions, h / R);
    constexpr int slabs = 4;
    Real sum = 0;
    for (int k = 0; k < slabs; ++k) {
        const Real from = h + (R - h) * k / slabs, to = h + (R - h) * (k + 1) / slabs;
        if (solid.distance(x - (from + to) / 2 * normal) < 0) sum += beyond(dimensions, from / R) - beyond(dimensions, to / R);
    }
    return sum;
}

}  // namespace

/// Fraction of the wall next to the particle that no other particle covers: 1 - sum b K over the particles nearer to the wall. K = (1 -
/// l^2/R^2)^2 depends on the distance l along the wall; its sum over a layer with one particle per spacing is about 1. b depends on how
/// much nearer to the wall the particle is.
Real CoupledRows::Scratch::uncovered(const Vec3& normal, int dimensions) const {
    const Real of_radius2 = dimensions == 2 ? Real(1.138) : Real(std::numbers::pi / 3);
    Real open = 1;
    for (std::size_t k = 0; k < index.size(); ++k) {
        const Real below = -(x[k] * normal[0] + y[k] * normal[1] + z[k] * normal[2]);
        if (!(below > Real(0.25))) continue;
        const Real bump = std::max(Real(0), 1 - (r2[k] - below * below) * of_radius2);
        open -= std::min(Real(1), 2 * below - Real(0.5)) * bump * bump;
    }
    return std::max(Real(0), open);
}

/// Finds the solids near the particle: their part of its density, and the wall points that hold it.
void CoupledRows::Scratch::find_walls(RowBlock& block, Index i, const Vec3& at, Real h, Real d, const Walls& walls, const CoupledOptions& o,
                                      Neighbourhood& n) const {
    const Solids& solids = walls.solids;
    const Real dt = walls.dt;
    const Real support = static_cast<Real>(o.support) * d, reach = static_cast<Real>(o.wall_reach) * d;
    // sum w z^2 over a half space full of particles, z: distance from its plane.
    const Real half_moment = walls.dimensions == 2 ? Real(std::numbers::pi / 80) * h * h * h * h
                                                   : Real(2 * std::numbers::pi / 3 * 16 / 1155) * h * h * h * h * h;
    const Real few = walls.dimensions == 2 ? 1 : 2;  // sum w is 1.2 for particles in a single file along the wall, 3.5 in a layer
    const std::size_t before = block.walls.size();
    constexpr Real no_lattice = Real(0.0119);  // deficit of each layer of a lattice that touches a flat wall
    Real open = 1;
    const auto count = [&](const Solid& solid, const Vec3& normal, Real height) {
        open *= 1 - std::max(Real(0), filled(walls.dimensions, solid, at, normal, height, support) - no_lattice);
    };
    const auto add = [&](const Solid& solid, Index k, const Vec3& normal, Real height) {
        const bool touches = solid.sticks() ? walls.held[i] > 0 : walls.slip[i] != Vec3::Zero();
        if (!touches || !(height < reach) || block.walls.size() - before == most_walls) return;
        WallPoint wall;
        wall.row = static_cast<Index>(row_first.size()) - 1;
        wall.solid = k;
        wall.normal = normal;
        const Real up = std::max(height / d, Real(0.2)),
                   hold = std::clamp((reach - height) / (Real(0.2) * d), Real(0), Real(1)) * uncovered(normal, walls.dimensions);
        if (!(hold > 0)) return;
        wall.position = at - up * d * normal;
        wall.velocity = velocity_over(solid, wall.position, dt);
        wall.weight = hold * 2 * half_moment / up;
        const Real lone = std::max(Real(0), 1 - std::accumulate(w.begin(), w.end(), Real(0)) / few);
        if (!solid.sticks()) {
            const Real b = static_cast<Real>(solid.slip_length), whole = up * d + b;
            wall.stick = up * d / whole;
            wall.friction = solid.partial_slip() ? hold * b / (whole * whole) : 0;
        }
        wall.lateral = wall.stick * hold * lone * half_moment / 2 * (Mat3::Identity() - normal * normal.transpose());
        if (walls.dimensions == 2) wall.lateral(2, 2) = 0;
        n.volume *= 1 + hold * (up - Real(0.5));
        block.walls.push_back(wall);
    };
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        const Solid& solid = solids.all[k];
        const Real height = solid.distance(at);
        if (!(height < support)) continue;
        const Vec3 normal = solid.normal(at);
        if (!(height < reach)) {
            count(solid, normal, height);
            continue;
        }
        add(solid, static_cast<Index>(k), normal, height);
        Real bend = 0;  // sum of distance - height at four points beside the particle, at the distance `reach`; for curved surfaces
        // The four points also find other faces of the same solid that meet the nearest face in a concave edge.
        int along = 0;
        const Vec3 in_own_axes = solid.pose.rotation.transpose() * normal;
        in_own_axes.cwiseAbs().minCoeff(&along);
        const Vec3 axis = solid.pose.rotation.col(along), t = (axis - normal * normal.dot(axis)).normalized(), s = normal.cross(t);
        for (const Vec3& way : {t, Vec3(-t), s, Vec3(-s)}) {
            Vec3 there = at + reach * way;
            Real beyond_it = solid.distance(there);
            if (std::abs(beyond_it - height) > Real(1e-3) * d && (walls.dimensions == 3 || way.z() == 0) &&
                solid.normal(there).dot(normal) > Real(0.7))
                bend += beyond_it - height;
            if (!(beyond_it < 0)) beyond_it = solid.distance(there = at + reach / 2 * way);  // the solid may be thin
            if (!(beyond_it < 0)) continue;
            const Vec3 face = solid.normal(there);
            if (face.dot(normal) > Real(0.7)) continue;
            const Real face_height = beyond_it - (there - at).dot(face);
            add(solid, static_cast<Index>(k), face, face_height);
            count(solid, face, face_height);
        }
        // The mean square of a component along the wall, over the section of the kernel by the wall, is (R^2 - h^2)/10, in 2D (R^2 -
        // h^2)/9.
        const Real section = (support * support - height * height) / (reach * reach);
        count(solid, normal, height + bend * section / (walls.dimensions == 2 ? 18 : 20));
    }
    n.density += 1 - open;
    // In an edge or a corner the particle has fewer neighbours along each wall. With whole weights a uniform pressure would not balance
    // there.
    const auto first = block.walls.begin() + static_cast<std::ptrdiff_t>(before);
    for (auto wall = first; wall != block.walls.end(); ++wall)
        for (auto other = first; other != block.walls.end(); ++other) {
            const Real across = 1 - std::pow(wall->normal.dot(other->normal), 2), height = (at - other->position).norm();
            if (other != wall) wall->weight *= 1 - static_cast<Real>(o.edge_share) * across * beyond(walls.dimensions, height / (h * d));
        }
}

/// Puts rows of similar length into the same slices.
void CoupledRows::Scratch::arrange(RowBlock& block) const {
    const Index rows = block.size();
    block.count.resize(rows), block.lane.resize(rows);
    for (Index row = 0; row < rows; ++row) block.count[row] = static_cast<std::uint16_t>(row_first[row + 1] - row_first[row]);
    std::vector<Index> by_length(rows);
    std::iota(by_length.begin(), by_length.end(), 0);
    std::stable_sort(by_length.begin(), by_length.end(), [&](Index a, Index b) { return block.count[a] > block.count[b]; });
    block.slices.assign(static_cast<std::size_t>((rows + lane_count - 1) / lane_count), RowSlice());
    block.wall_weight.clear();
    std::vector<Index> wall_count(rows, 0);
    for (const WallPoint& wall : block.walls) ++wall_count[wall.row];
    std::size_t end = 0;
    for (std::size_t k = 0; k < block.slices.size(); ++k) {
        RowSlice& slice = block.slices[k];
        slice.begin = end;
        slice.first_wall = block.wall_weight.size();
        for (Index lane = 0; lane < std::min<Index>(lane_count, rows - static_cast<Index>(k) * lane_count); ++lane)
            slice.walls = std::max(slice.walls, wall_count[by_length[k * lane_count + static_cast<std::size_t>(lane)]]);
        slice.width = block.count[by_length[k * lane_count]] + slice.walls;
        block.wall_weight.resize(slice.first_wall + static_cast<std::size_t>(slice.walls), Lanes{});
        end += static_cast<std::size_t>(slice.width) * lane_count;
    }
    block.other.resize(end);
    for (std::size_t k = 0; k < block.slices.size(); ++k) {
        RowSlice& slice = block.slices[k];
        slice.rows = std::min<Index>(lane_count, rows - static_cast<Index>(k) * lane_count);
        for (Index lane = 0; lane < lane_count; ++lane) {
            const Index row = by_length[k * lane_count + static_cast<std::size_t>(lane < slice.rows ? lane : 0)];
            const Index count = lane < slice.rows ? block.count[row] : 0;
            slice.row[lane] = static_cast<std::uint16_t>(row);
            slice.of_h2[lane] = 1 / (row_h[row] * row_h[row]);
            std::size_t to = slice.begin + static_cast<std::size_t>(lane), from = row_first[row];
            if (lane < slice.rows) block.lane[row] = static_cast<std::uint16_t>(k * lane_count + static_cast<std::size_t>(lane));
            for (Index e = 0; e < count; ++e, ++from, to += lane_count) block.other[to] = row_other[from];
            for (Index e = count; e < slice.width; ++e, to += lane_count) block.other[to] = static_cast<RowBlock::LocalIndex>(row);
        }
    }
    for (std::size_t k = 0, of_row = 0; k < block.walls.size(); ++k) {
        const Index row = block.walls[k].row;
        of_row = k > 0 && block.walls[k - 1].row == row ? of_row + 1 : 0;
        const RowSlice& slice = block.slice_of(row);
        const Index lane = block.lane_in_slice(row);
        block.wall_weight[slice.first_wall + of_row][lane] = block.walls[k].weight;
        block.other[slice.begin + (static_cast<std::size_t>(slice.plain()) + of_row) * lane_count + static_cast<std::size_t>(lane)] =
            static_cast<RowBlock::LocalIndex>(block.touched.size() + k);
    }
}

template <bool with>
const Vec4* CoupledRows::take(const RowBlock& block, Span<const Vec3> u, bool moving) const {
    thread_local Column<Vec4> memory;
    const std::size_t count = block.entries(), each = with ? 2 : 1;
    if (memory.size() < each * count) memory.resize(each * count);
    const auto first = quad(x_[block.begin]);
    Vec4* to = memory.data();
    for (const Index j : block.touched) {
        quad(*to++) = (quad(x_[j]) - first) * of_spacing_;
        if constexpr (with) *to++ = with_spare(u[j]);
    }
    for (const WallPoint& wall : block.walls) {
        const Vec4 point = with_spare(wall.position);
        quad(*to++) = (quad(point) - first) * of_spacing_;
        if constexpr (with) {
            Vec3 velocity = moving ? wall.velocity : Vec3(Vec3::Zero());
            if (wall.slides()) velocity += wall.slipping(u[block.begin + wall.row] - velocity);
            *to++ = with_spare(velocity);
        }
    }
    return memory.data();
}
const Vec4* CoupledRows::positions(const RowBlock& block) const { return take<false>(block, {}, false); }
const Vec4* CoupledRows::positions(const RowBlock& block, Span<const Vec3> u, bool moving) const { return take<true>(block, u, moving); }

/// Computes sums over the finished rows: M, its inverse, the surface indicator, and the fourth moment.
void CoupledRows::find_moments(RowBlock& block, const CoupledOptions& o) {
    const Vec4* at = positions(block);
    block.directions.clear();
    for (RowSlice& slice : block.slices) {
        SymmetricLanes M{};
        Lanes3 centre{};
        Lanes distances{}, weights{};
        FourthMoment& fourth = slice.fourth;
        for (Lanes& v : fourth.v) v = Lanes{};
        const auto add = [&](const PairLanes& p) {
            const Lanes x = p.r.x, y = p.r.y, z = p.r.z, w = p.w;
            const Lanes xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z;
            M.xx += w * xx, M.yy += w * yy, M.zz += w * zz, M.xy += w * xy, M.xz += w * xz, M.yz += w * yz;
            const Lanes wi = w / p.r2;
            const Lanes wxx = wi * xx, wyy = wi * yy, wzz = wi * zz;
            Lanes* f = fourth.v;
            f[0] += wxx * xx, f[1] += wxx * xy, f[2] += wxx * xz, f[3] += wxx * yy, f[4] += wxx * yz, f[5] += wxx * zz;
            f[6] += wyy * xy, f[7] += wyy * xz, f[8] += wzz * xy, f[9] += wzz * xz;
            f[10] += wyy * yy, f[11] += wyy * yz, f[12] += wyy * zz, f[13] += wzz * yz, f[14] += wzz * zz;
        };
        pairs_of(block, slice, at).each_plain([&](std::size_t, const PairLanes& p) {
            add(p);
            weights += p.w;
            centre = centre + p.w * p.r;
            distances += p.w * square_root(p.r2);
        });
        const SymmetricLanes without_walls = M;
        pairs_of(block, slice, at).each_wall([&](std::size_t, const PairLanes& p) { add(p); });
        slice.inverse_moment = SymmetricLanes();
        for (Index lane = 0; lane < slice.rows; ++lane) {
            const Index row = slice.row[lane];
            Neighbourhood& n = neighbourhood[block.begin + row];
            Vec3 middle(centre.x[lane], centre.y[lane], centre.z[lane]);
            if (slice.walls > 0)  // as if the mirror image of the fluid continued behind the wall
                for (const WallPoint& wall : block.walls)
                    if (wall.row == row) middle -= wall.normal * wall.normal.dot(middle);
            n.weights = weights[lane];
            n.spread = M.xx[lane] + M.yy[lane] + M.zz[lane];
            if (distances[lane] > 0) n.surface = middle.norm() / distances[lane];
            if (n.surface > 0) n.outward = -middle.normalized();
            if (n.spread > 0) {
                MomentShape shape = shape_of(lane_of(without_walls, lane), o, dimensions_, n);
                if (slice.walls > 0) add_walls(block, row, lane_of(M, lane), o, dimensions_, n, shape);
                set_lane(slice.inverse_moment, lane, shape.inverse_moment);
                if (!shape.volume) {
                    n.directions = static_cast<std::int32_t>(block.directions.size());
                    block.directions.push_back(shape.directions);
                }
            }
            slice.resolved = slice.resolved && n.unresolved == 0;
        }
    }
}

/// Lists for every particle the entries that blocks have for it, in the order of the blocks.
void CoupledRows::number_slots() {
    first_slot_.assign(neighbourhood.size() + 1, 0);
    std::size_t place = 0;
    for (RowBlock& block : blocks) {
        block.place = place;
        place += block.entries();
        for (Index j : block.touched) ++first_slot_[j + 1];
    }
    WHORL_ASSERT(place <= std::numeric_limits<std::uint32_t>::max(), +std::to_string(place) + " entries");
    for (std::size_t i = 1; i < first_slot_.size(); ++i) first_slot_[i] += first_slot_[i - 1];
    entries_ = place;
    slot_.resize(first_slot_.back());
    std::vector<std::uint32_t> next(first_slot_.begin(), first_slot_.end() - 1);
    for (const RowBlock& block : blocks)
        for (std::size_t l = 0; l < block.touched.size(); ++l)
            slot_[next[block.touched[l]]++] = static_cast<std::uint32_t>(block.place + l);
}

}  // namespace whorl

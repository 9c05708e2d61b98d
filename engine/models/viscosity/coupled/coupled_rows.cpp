#include "engine/models/viscosity/coupled/coupled_rows.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>

#include "engine/core/parallel.h"
#include "engine/math/kernel.h"
#include "engine/models/viscosity/coupled/row_builder.h"

namespace whorl {
namespace {

/// (1 - q^2)^3 as a function of q^2. A Wendland kernel with the same second moment has 1.17 times the radius and 1.6 times the pairs.
Real weight_at(Real q2) {
    const Real p = std::max(Real(0), 1 - q2);
    return p * p * p;
}

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

void CoupledRows::build(Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing,
                        const CoupledOptions& options, const TouchedSolids& solids) {
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

    Walls near_walls{solids, dimensions_, nearest_solid};
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
    const std::size_t bodies = x_.size();  // index of the bodies' first entry
    for (const WallPoint& wall : block.walls) {
        const Vec4 point = with_spare(wall.position);
        quad(*to++) = (quad(point) - first) * of_spacing_;
        if constexpr (with) {
            Vec3 velocity = moving ? wall.velocity : Vec3(Vec3::Zero());
            if (wall.body >= 0 && u.size() > bodies) velocity = wall.carried_by(u.subspan(bodies));
            if (wall.slides()) velocity += wall.slipping(u[block.begin + wall.row] - velocity);
            *to++ = with_spare(velocity);
        }
    }
    return memory.data();
}
const Vec4* CoupledRows::positions(const RowBlock& block) const { return take<false>(block, {}, false); }
const Vec4* CoupledRows::positions(const RowBlock& block, Span<const Vec3> u, bool moving) const { return take<true>(block, u, moving); }

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

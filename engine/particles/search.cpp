// This file is compiled without reassociation (CMakeLists.txt): (x_i - x_j) - L must not become (x_i - L) - x_j, or the two rows of a pair
// across a periodic border could disagree.
#include "engine/particles/search.h"

#include <limits>

#include "engine/core/column.h"
#include "engine/core/parallel.h"
#include "engine/particles/distance_test.h"

namespace whorl {
namespace {

/// Edge of a cell relative to the support, along x (the cells of a run are contiguous) and along y and z. These values were the fastest in
/// tools/bench/bench_particles.cpp.
constexpr double edge_along = 0.5, edge_across = 1;

bool is_finite(const Vec3& x) { return std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]); }

}  // namespace

int NeighbourSearch::Axis::bin(double cell) const {
    if (cell >= 0 && cell < bins) return static_cast<int>(cell);
    if (wraps) cell -= bins * std::floor(cell / bins);
    return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(bins - 1)));
}

/// Radius of the search, slightly beyond the support, so that rounding in the cells cannot lose a pair that the test would accept.
struct NeighbourSearch::Reach {
    double radius;
    DistanceTest test;
};

struct NeighbourSearch::Rows {
    Column<Index>& entries;
    std::size_t used = 0;
    Index* room_for(Index candidates) {
        const std::size_t needed = used + static_cast<std::size_t>(candidates + 2 * most_lanes);
        if (entries.size() < needed) entries.resize(std::max(2 * entries.size(), needed));
        return entries.data() + used;
    }
};

/// Makes the rows of blocks of particles in parallel, then joins them. It works on a batch of blocks at a time, so that the copies stay
/// small and in the cache. If every new row is at most as long as the old one, make() may still read the old rows of its own and of later
/// batches in `pairs`.
/// @param make called for the particles [begin, end): appends their rows, and sets pairs.first[i + 1] to the end of row i within the block
template <class F>
void NeighbourSearch::join_blocks(Index n, Pairs& pairs, std::vector<Column<Index>>& memory, const F& make) {
    constexpr Index batch = 32 * block;
    memory.resize(batch / block);
    std::size_t total = 0;
    for (Index from = 0; from < n; from += batch) {
        const Index count = std::min(batch, n - from);
        parallel_blocks(count, block, [&](Index begin, Index end) {
            Rows rows{memory[begin / block]};
            make(from + begin, from + end, rows);
        });
        std::size_t offset[batch / block];
        for (Index begin = 0; begin < count; begin += block) {
            offset[begin / block] = total;
            total += pairs.first[from + std::min(begin + block, count)];
        }
        if (pairs.other.size() < total) {
            const double expected = static_cast<double>(total) / (from + count) * n;
            resize_tightly(pairs.other, std::max(total, static_cast<std::size_t>(expected)));
        }
        parallel_blocks(count, block, [&](Index begin, Index end) {
            const std::size_t shift = offset[begin / block], found = pairs.first[from + end];
            std::copy_n(memory[begin / block].data(), found, pairs.other.data() + shift);
            for (Index i = from + begin; i < from + end; ++i) pairs.first[i + 1] += shift;
        });
    }
    pairs.other.resize(total);
}

void NeighbourSearch::choose_axes(Span<const Vec3> x, Real support, const Domain& domain) {
    const double inf = std::numeric_limits<double>::infinity();
    struct Box {
        Eigen::Array3d min, max;
        Box& operator+=(const Box& b) {
            min = min.min(b.min);
            max = max.max(b.max);
            return *this;
        }
    };
    const Box empty{Eigen::Array3d::Constant(inf), Eigen::Array3d::Constant(-inf)};
    const Box box = parallel_sum(static_cast<Index>(x.size()), empty, [&](Index i) {
        const Vec3& xi = x[i];
        if (!is_finite(xi)) return empty;
        return Box{xi.cast<double>().array(), xi.cast<double>().array()};
    });

    axes_ = domain.dimensions();
    if (axes_ == 2) axis_[2] = {};
    double cells[3] = {1, 1, 1};
    for (int a = 0; a < axes_; ++a) {
        const double edge = support * (a == 0 ? edge_along : edge_across);
        Axis& axis = axis_[a];
        if (domain.periodic[a]) {
            const double length = double(domain.max[a]) - double(domain.min[a]);
            WHORL_ASSERT(length >= 2 * double(support) * (1 - 1e-5),
                         +std::string("axis of ") + std::to_string(length) + " m, support " + std::to_string(support) + " m");
            axis.origin = domain.min[a];
            cells[a] = std::min(std::floor(length / edge), most_cells);
            axis.edge = length / cells[a];
            axis.wraps = true;
        } else {
            const bool any = box.min[a] <= box.max[a];
            axis.origin = any ? box.min[a] : 0;
            cells[a] = any ? std::min(std::floor((box.max[a] - box.min[a]) / edge) + 1, most_cells) : 1;
            axis.edge = edge;
            axis.wraps = false;
        }
    }
    // Limits the number of bins to a few per particle: cells of the longest axes share bins. Along a periodic axis the number of cells must
    // be a multiple of the number of bins, so cells are enlarged below if necessary.
    const double most = 8.0 * static_cast<double>(x.size()) + 1024;
    double bins[3] = {cells[0], cells[1], cells[2]};
    while (bins[0] * bins[1] * bins[2] > most) {
        const int longest = static_cast<int>(std::max_element(bins, bins + 3) - bins);
        bins[longest] = std::floor(bins[longest] / 2);
        axis_[longest].wraps = true;
    }
    for (int a = 0; a < axes_; ++a) {
        Axis& axis = axis_[a];
        axis.bins = static_cast<int>(bins[a]);
        if (domain.periodic[a]) {
            const double length = axis.edge * cells[a];
            axis.edge = length / (bins[a] * std::floor(cells[a] / bins[a]));
        }
        axis.inverse_edge = 1 / axis.edge;
    }
}

void NeighbourSearch::fill_bins(Span<const Vec3> x, const Domain& domain) {
    const std::size_t n = x.size();
    bin_of_.resize(n);
    parallel_for(static_cast<Index>(n), [&](Index i) {
        if (!is_finite(x[i])) {
            bin_of_[i] = -1;
            return;
        }
        const Vec3 xi = domain.wrapped(x[i]);
        int bin[3] = {0, 0, 0};
        for (int a = 0; a < axes_; ++a) bin[a] = axis_[a].bin(axis_[a].cell(xi[a]));
        bin_of_[i] = (bin[2] * axis_[1].bins + bin[1]) * axis_[0].bins + bin[0];
    });

    // Counting sort. It is stable: within a bin, particles are in the order of the store.
    const std::size_t bins =
        static_cast<std::size_t>(axis_[0].bins) * static_cast<std::size_t>(axis_[1].bins) * static_cast<std::size_t>(axis_[2].bins);
    start_.assign(bins + 2, 0);
    for (std::size_t k = 0; k < n; ++k)
        if (bin_of_[k] >= 0) ++start_[bin_of_[k] + 2];
    for (std::size_t b = 2; b < bins + 2; ++b) start_[b] += start_[b - 1];
    for (auto& column : packed_) column.resize(n + 2 * most_lanes, 0);
    packed_index_.resize(n + 2 * most_lanes, 0);
    for (std::size_t k = 0; k < n; ++k) {
        if (bin_of_[k] < 0) continue;
        const std::size_t place = static_cast<std::size_t>(start_[bin_of_[k] + 1]++);
        const Vec3 xi = domain.wrapped(x[k]);
        for (int a = 0; a < 3; ++a) packed_[a][place] = xi[a];
        packed_index_[place] = static_cast<Index>(k);
    }
}

template <bool periodic>
void NeighbourSearch::append_row(const Vec3& x, Index self, const Reach& reach, Rows& rows) const {
    DistanceTest test = reach.test;
    test.self = self;
    double low[3] = {0, 0, 0};
    int count[3] = {1, 1, 1};
    for (int a = 0; a < 3; ++a) test.x[a] = x[a];
    for (int a = 0; a < axes_; ++a) {
        low[a] = axis_[a].cell(double(x[a]) - reach.radius);
        double high = axis_[a].cell(double(x[a]) + reach.radius);
        if (!axis_[a].wraps) {
            low[a] = std::max(low[a], 0.0);
            high = std::min(high, static_cast<double>(axis_[a].bins - 1));
            if (!(low[a] <= high)) return;
        }
        count[a] = static_cast<int>(std::min(high - low[a] + 1, static_cast<double>(axis_[a].bins)));  // no bin twice
    }
    int low_bin[3];
    for (int a = 0; a < 3; ++a) low_bin[a] = axis_[a].bin(low[a]);
    const auto bin = [&](int a, int k) {
        const Axis& axis = axis_[a];
        return axis.wraps ? axis.bin(low[a] + k) : low_bin[a] + k;
    };
    // Along x the bins are contiguous, so each row of bins is one run, or two runs if the range wraps around.
    const int columns = axis_[0].bins;
    const int first = low_bin[0];
    const int past = std::min(first + count[0], columns), wrapped = first + count[0] - past;
    const Real* const p[3] = {packed_[0].data(), packed_[1].data(), packed_[2].data()};

    const auto visit = [&](std::size_t row, int from, int to) {
        const Index begin = start_[row + from], end = start_[row + to];
        if (begin == end) return;
        Index* const out = rows.room_for(end - begin);
        rows.used += static_cast<std::size_t>(append_near<periodic>(test, p, packed_index_.data(), begin, end, out) - out);
    };
    for (int k = 0; k < count[2]; ++k) {
        const std::size_t slab = static_cast<std::size_t>(bin(2, k)) * static_cast<std::size_t>(axis_[1].bins);
        for (int l = 0; l < count[1]; ++l) {
            const std::size_t row = (slab + static_cast<std::size_t>(bin(1, l))) * static_cast<std::size_t>(columns);
            visit(row, first, past);
            if (wrapped > 0) visit(row, 0, wrapped);
        }
    }
}

template <bool periodic>
void NeighbourSearch::fill_rows(Span<const Vec3> own, Index first, Real support, const Domain& domain, Pairs& pairs) {
    const Reach reach{double(support) * (1 + 1e-5), test_for(support, domain)};
    const Index n = static_cast<Index>(own.size());
    pairs.first.resize(own.size() + 1);
    pairs.first[0] = 0;
    join_blocks(n, pairs, rows_, [&](Index begin, Index end, Rows& rows) {
        for (Index i = begin; i < end; ++i) {
            if (is_finite(own[i])) append_row<periodic>(domain.wrapped(own[i]), first < 0 ? -1 : first + i, reach, rows);
            pairs.first[i + 1] = rows.used;
        }
    });
}

void NeighbourSearch::find(Span<const Vec3> x, Real support, const Domain& domain, Pairs& pairs) { find(x, x, support, domain, pairs); }

void NeighbourSearch::find(Span<const Vec3> x_own, Span<const Vec3> x_other, Real support, const Domain& domain, Pairs& pairs) {
    pairs.x_other = x_other;
    const bool among_themselves = x_own.data() == x_other.data() && x_own.size() == x_other.size();
    start(x_other, support, domain);
    fill_rows(x_own, among_themselves ? 0 : -1, support, domain, pairs);
}

void NeighbourSearch::start(Span<const Vec3> x, Real support, const Domain& domain) {
    if (x.empty()) return;
    choose_axes(x, support, domain);
    fill_bins(x, domain);
}

void NeighbourSearch::rows(Span<const Vec3> x, Index begin, Index end, Real support, const Domain& domain, Pairs& part) {
    part.x_other = x;
    fill_rows(x.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)), begin, support, domain, part);
}

void NeighbourSearch::fill_rows(Span<const Vec3> own, Index first, Real support, const Domain& domain, Pairs& pairs) {
    pairs.x_own = own;
    pairs.period = domain.period();
    pairs.support = support;
    pairs.found_own.clear(), pairs.found_other.clear();
    if (pairs.x_other.empty()) {
        pairs.first.assign(own.size() + 1, 0);
        pairs.other.clear();
        return;
    }
    if (domain.any_periodic()) fill_rows<true>(own, first, support, domain, pairs);
    else fill_rows<false>(own, first, support, domain, pairs);
}

namespace {

/// Largest displacement of any particle [m], to the nearest periodic image.
double farthest_move(Span<const Vec3> from, Span<const Vec3> to, const Domain& domain) {
    const Vec3 period = domain.period();
    return std::sqrt(parallel_max(static_cast<Index>(to.size()), 0, [&](Index i) {
        Vec3 move = to[i] - from[i];
        for (int a = 0; a < 3; ++a)
            if (period[a] > 0) move[a] -= period[a] * std::nearbyint(move[a] / period[a]);
        const double squared = static_cast<double>(move.squaredNorm());
        return std::isfinite(squared) ? squared : std::numeric_limits<double>::infinity();
    }));
}

/// Copies the neighbours in row `other` that are within the support to `out`. @returns their number
template <bool periodic>
Index keep_near(const DistanceTest& test, Span<const Vec3> x, const Index* other, Index count, Index* out) {
    constexpr Index most = 64;
    alignas(64) Index index[most + 2 * most_lanes], near[most + 4 * most_lanes];
    alignas(64) Real at[3][most + 2 * most_lanes];
    const Real* const p[3] = {at[0], at[1], at[2]};
    Index kept = 0;
    for (Index k = 0; k < count; k += most) {
        const Index group = std::min(most, count - k), padded = (group + 2 * most_lanes - 1) & -(2 * most_lanes);
        for (Index l = 0; l < padded; ++l) index[l] = other[k + (l < group ? l : 0)];
        gather(x.data(), index, padded, at);
        const Index found = static_cast<Index>(append_near<periodic>(test, p, index, 0, group, near) - near);
        std::copy_n(near, found, out + kept);
        kept += found;
    }
    return kept;
}

}  // namespace

void NeighbourSearch::find_wide(Span<const Vec3> x_own, Span<const Vec3> x_other, Real reach, const Domain& domain, Pairs& pairs) {
    find(x_own, x_other, reach, domain, pairs);
    pairs.found_own.assign(x_own.begin(), x_own.end());
    if (x_own.data() != x_other.data()) pairs.found_other.assign(x_other.begin(), x_other.end());
}

bool NeighbourSearch::narrow(Span<const Vec3> x_own, Span<const Vec3> x_other, Real support, const Domain& domain, Pairs& pairs) {
    const bool among_themselves = x_own.data() == x_other.data();
    Column<Vec3>&found_own = pairs.found_own, &found_other = among_themselves ? pairs.found_own : pairs.found_other;
    if (found_own.size() != x_own.size() || found_other.size() != x_other.size() || x_own.empty() || x_other.empty()) return false;
    const double spare = 0.99 * static_cast<double>(pairs.support - support);  // minus rounding errors
    const double own = farthest_move(found_own, x_own, domain);
    if (!(own + (among_themselves ? own : farthest_move(found_other, x_other, domain)) <= spare)) return false;
    Column<Vec3>().swap(pairs.found_own), Column<Vec3>().swap(pairs.found_other);  // not needed until the next find_wide()
    pairs.x_own = x_own, pairs.x_other = x_other;
    pairs.support = support;

    const DistanceTest test = test_for(support, domain);
    const auto n = static_cast<Index>(x_own.size());
    std::vector<std::size_t> begins;  // start of each block's rows in `other`, because join_blocks() overwrites `first`
    for (Index begin = 0; begin < n; begin += block) begins.push_back(pairs.first[begin]);
    begins.push_back(pairs.first[n]);
    const auto run = [&]<bool periodic>() {
        std::vector<Column<Index>> memory;
        join_blocks(n, pairs, memory, [&](Index begin, Index end, Rows& rows) {
            std::size_t from = begins[begin / block];
            const std::size_t past = begins[begin / block + 1];
            Index* const out = rows.room_for(static_cast<Index>(past - from));
            for (Index i = begin; i < end; ++i) {
                const std::size_t next = i + 1 < end ? pairs.first[i + 1] : past;
                DistanceTest of_row = test;
                for (int a = 0; a < 3; ++a) of_row.x[a] = x_own[i][a];
                of_row.self = -1;
                rows.used += static_cast<std::size_t>(
                    keep_near<periodic>(of_row, x_other, pairs.other.data() + from, static_cast<Index>(next - from), out + rows.used));
                from = next;
                pairs.first[i + 1] = rows.used;
            }
        });
    };
    if (domain.any_periodic()) run.template operator()<true>();
    else run.template operator()<false>();
    return true;
}

std::size_t NeighbourSearch::capacity_bytes() const {
    std::size_t bytes = (bin_of_.capacity() + start_.capacity() + packed_index_.capacity()) * sizeof(Index);
    for (const auto& column : packed_) bytes += column.capacity() * sizeof(Real);
    for (const auto& rows : rows_) bytes += rows.capacity() * sizeof(Index);
    return bytes;
}

}  // namespace whorl

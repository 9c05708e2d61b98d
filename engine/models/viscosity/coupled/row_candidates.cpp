// Neighbours within the support of each particle, and the gate that admits them to the row.
#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/coupled/row_builder.h"

namespace whorl {

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

}  // namespace whorl

#include "render/flow/flow_grid.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// An index on an axis; -1 outside.
int on_axis(const FlowGrid& g, int axis, int i) {
    if (g.periodic[axis]) return ((i % g.n[axis]) + g.n[axis]) % g.n[axis];
    return i >= 0 && i < g.n[axis] ? i : -1;
}

bool finite(const Vec3f& x) { return std::isfinite(x.x()) && std::isfinite(x.y()) && std::isfinite(x.z()); }

/// Box, nodes and cells; the fluid's box with a margin, the whole domain along periodic axes.
FlowGrid laid_out(const Frame& frame, float reach, std::size_t most_nodes, float cell) {
    Vec3f low = Vec3f::Constant(1e30f), high = Vec3f::Constant(-1e30f);
    for (const Vec3f& x : frame.position)
        if (finite(x)) low = low.cwiseMin(x), high = high.cwiseMax(x);
    FlowGrid grid;
    if (low.x() > high.x()) return grid;
    grid.periodic = frame.periodic;
    for (int a = 0; a < 3; ++a) {
        if (frame.periodic[a]) low[a] = frame.domain_min[a], high[a] = frame.domain_max[a];
        else low[a] -= reach, high[a] += reach;
    }
    const bool plane = frame.dimensions == 2;
    if (plane) low.z() = -0.5f * frame.spacing, high.z() = 0.5f * frame.spacing, grid.periodic[2] = true;  // one node, wherever z
    for (;; cell *= 1.25f) {
        double nodes = 1;
        for (int a = 0; a < 3; ++a) {
            // A periodic axis has whole cells; another one more node than cells.
            const float cells = plane && a == 2 ? 1 : std::max(1.0f, std::round((high[a] - low[a]) / cell));
            grid.n[a] = static_cast<int>(cells) + (grid.periodic[a] ? 0 : 1);
            grid.cell[a] = (high[a] - low[a]) / cells;
            nodes *= grid.n[a];
        }
        if (nodes <= static_cast<double>(most_nodes)) break;
    }
    grid.origin = low;
    return grid;
}

/// Particles by the grid's cells, in their own order within each.
struct Bins {
    std::vector<std::uint32_t> start, particle;
};
Bins binned(const FlowGrid& grid, const std::vector<Vec3f>& position) {
    const std::size_t cells = grid_count(grid.n[0], grid.n[1], grid.n[2]);
    std::vector<std::int64_t> bin(position.size(), -1);
    parallel_for(static_cast<Index>(position.size()), [&](Index p) {
        const Vec3f& x = position[p];
        if (!finite(x)) return;
        int at[3];
        for (int a = 0; a < 3; ++a) at[a] = on_axis(grid, a, static_cast<int>(std::floor((x[a] - grid.origin[a]) / grid.cell[a])));
        if (at[0] >= 0 && at[1] >= 0 && at[2] >= 0) bin[p] = static_cast<std::int64_t>(grid.index(at[0], at[1], at[2]));
    });
    Bins bins{std::vector<std::uint32_t>(cells + 1), {}};
    for (const std::int64_t b : bin)
        if (b >= 0) ++bins.start[b + 1];
    for (std::size_t c = 0; c < cells; ++c) bins.start[c + 1] += bins.start[c];
    bins.particle.resize(bins.start[cells]);
    std::vector<std::uint32_t> next(bins.start.begin(), bins.start.end() - 1);
    for (std::size_t p = 0; p < bin.size(); ++p)
        if (bin[p] >= 0) bins.particle[next[bin[p]]++] = static_cast<std::uint32_t>(p);
    return bins;
}

}  // namespace

FlowGrid flow_grid(const Frame& frame, const std::vector<Vec3f>& along, const std::vector<Eigen::Vector4f>& value, std::size_t most_nodes,
                   float cell_in_spacings) {
    // full: sum of the weights in a full lattice, 4 pi (1/3 - 2/5 + 1/7) 1.5^3; in the plane pi/3 1.5^2.
    constexpr float reach_in_spacings = 1.5f;
    const float full = frame.dimensions == 2 ? 2.36f : 3.2f;
    FlowGrid grid = laid_out(frame, reach_in_spacings * frame.spacing, most_nodes, cell_in_spacings * frame.spacing);
    if (grid.n[0] == 0) return grid;
    const float h = std::max(reach_in_spacings * frame.spacing, 1.2f * grid.cell.maxCoeff());
    const float lattice = full * std::pow(h / (reach_in_spacings * frame.spacing), static_cast<float>(frame.dimensions));
    const Bins bins = binned(grid, frame.position);
    const std::size_t nodes = bins.start.size() - 1;
    grid.along.assign(nodes, Vec3f::Zero());
    if (!value.empty()) grid.value.assign(nodes, Eigen::Vector4f::Zero());
    grid.cover.assign(nodes, 0);
    int reach[3];
    // A periodic axis shorter than the reach would meet the same cell twice.
    for (int a = 0; a < 3; ++a) {
        reach[a] = static_cast<int>(std::ceil(h / grid.cell[a]));
        if (grid.periodic[a]) reach[a] = std::min(reach[a], (grid.n[a] - 1) / 2);
    }
    parallel_for(static_cast<Index>(nodes), [&](Index node) {
        const int i = node % grid.n[0], j = node / grid.n[0] % grid.n[1], k = node / grid.n[0] / grid.n[1];
        const Vec3f x = grid.origin + grid.cell.cwiseProduct(Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)));
        const Vec3f period = grid.extent();
        float weight = 0;
        Eigen::Vector4f values = Eigen::Vector4f::Zero();
        Vec3f ways = Vec3f::Zero();
        for (int dk = -reach[2]; dk <= reach[2]; ++dk)
            for (int dj = -reach[1]; dj <= reach[1]; ++dj)
                for (int di = -reach[0]; di <= reach[0]; ++di) {
                    const int a = on_axis(grid, 0, i + di), b = on_axis(grid, 1, j + dj), c = on_axis(grid, 2, k + dk);
                    if (a < 0 || b < 0 || c < 0) continue;
                    const std::size_t cell = grid.index(a, b, c);
                    for (std::uint32_t s = bins.start[cell]; s < bins.start[cell + 1]; ++s) {
                        const std::uint32_t p = bins.particle[s];
                        Vec3f r = x - frame.position[p];
                        for (int axis = 0; axis < 3; ++axis)
                            if (grid.periodic[axis]) r[axis] -= period[axis] * std::nearbyint(r[axis] / period[axis]);
                        const float q = 1 - r.squaredNorm() / (h * h);
                        if (q <= 0) continue;
                        const float w = q * q;
                        weight += w;
                        ways += w * along[p];
                        if (!value.empty()) values += w * value[p];
                    }
                }
        if (weight <= 0) return;
        grid.along[node] = ways / weight;
        if (!value.empty()) grid.value[node] = values / weight;
        grid.cover[node] = std::min(1.0f, weight / lattice);
    });
    return grid;
}

FlowGrid::Corners FlowGrid::corners(const Vec3f& x) const {
    int low[3], high[3];
    float share[3];
    for (int a = 0; a < 3; ++a) {
        const float place = (x[a] - origin[a]) / cell[a], floor = std::floor(place);
        share[a] = place - floor;
        low[a] = on_axis(*this, a, static_cast<int>(floor));
        high[a] = on_axis(*this, a, static_cast<int>(floor) + 1);
    }
    Corners corners{};
    for (int corner = 0; corner < 8; ++corner) {
        float w = 1;
        int c[3];
        for (int a = 0; a < 3; ++a) {
            const bool upper = (corner >> a) & 1;
            c[a] = upper ? high[a] : low[a];
            w *= upper ? share[a] : 1 - share[a];
        }
        const bool stands = c[0] >= 0 && c[1] >= 0 && c[2] >= 0 && w > 0;
        corners.node[corner] = stands ? static_cast<std::int64_t>(index(c[0], c[1], c[2])) : -1;
        corners.weight[corner] = w;
    }
    return corners;
}

FlowGrid::Sample FlowGrid::at(const Vec3f& x) const {
    Sample sample;
    if (empty()) return sample;
    const Corners near = corners(x);
    float weights = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const std::int64_t m = near.node[corner];
        if (m < 0) continue;
        const float w = near.weight[corner];
        sample.cover += w * cover[m];
        if (cover[m] <= 0) continue;  // has nothing to tell
        weights += w;
        sample.along += w * along[m];
        if (!value.empty()) sample.value += w * value[m];
    }
    if (weights > 0) sample.along /= weights, sample.value /= weights;
    return sample;
}

}  // namespace whorl

#include "render/flow/flow_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Index of node i on an axis, wrapped if the axis is periodic; -1: outside the grid.
int on_axis(const FlowGrid& g, int axis, int i) {
    if (g.periodic[axis]) return ((i % g.n[axis]) + g.n[axis]) % g.n[axis];
    return i >= 0 && i < g.n[axis] ? i : -1;
}

bool finite(const Vec3f& x) { return std::isfinite(x.x()) && std::isfinite(x.y()) && std::isfinite(x.z()); }

/// Grid without values. Along a periodic axis it covers the whole domain, along the others the fluid and a margin of `reach` [m].
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
    if (plane) low.z() = -0.5f * frame.spacing, high.z() = 0.5f * frame.spacing, grid.periodic[2] = true;  // one node, for any z
    for (;; cell *= 1.25f) {
        double nodes = 1;
        for (int a = 0; a < 3; ++a) {
            // A periodic axis has as many nodes as cells, another axis one more.
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

/// Particles within 2 h of a value that is not 0, and some others nearby: no others change the values of nodes.
std::vector<char> near_values(const FlowGrid& grid, float h, const std::vector<Vec3f>& position,
                              const std::vector<Eigen::Vector4f>& value) {
    FlowGrid blocks;  // at least h wide
    blocks.periodic = grid.periodic;
    for (int a = 0; a < 3; ++a) {
        blocks.n[a] = std::max(1, static_cast<int>(grid.extent()[a] / h));
        blocks.cell[a] = grid.extent()[a] / static_cast<float>(blocks.n[a]);
    }
    const auto block_of = [&](const Vec3f& x, int a) {
        return std::clamp(static_cast<int>((x[a] - grid.origin[a]) / blocks.cell[a]), 0, blocks.n[a] - 1);
    };
    std::vector<char> source(grid_count(blocks.n[0], blocks.n[1], blocks.n[2]), 0), marked = source, near(position.size(), 0);
    const auto each = [&](const auto& f) {
        for (std::size_t p = 0; p < position.size(); ++p)
            if (const Vec3f& x = position[p]; finite(x)) f(p, block_of(x, 0), block_of(x, 1), block_of(x, 2));
    };
    each([&](std::size_t p, int i, int j, int k) {
        if (value[p].isZero(0) || std::exchange(source[blocks.index(i, j, k)], 1)) return;
        for (int m = 0; m < 125; ++m) {  // up to two blocks away
            const int at[3] = {on_axis(blocks, 0, i + m % 5 - 2), on_axis(blocks, 1, j + m / 5 % 5 - 2),
                               on_axis(blocks, 2, k + m / 25 - 2)};
            if (*std::min_element(at, at + 3) >= 0) marked[blocks.index(at[0], at[1], at[2])] = 1;
        }
    });
    each([&](std::size_t p, int i, int j, int k) { near[p] = marked[blocks.index(i, j, k)]; });
    return near;
}

/// Particles by the layer of nodes below them, in index order. The last list contains the particles outside all layers.
/// @param wanted by particle; empty: all
std::vector<std::vector<std::uint32_t>> by_layer(const FlowGrid& grid, const std::vector<Vec3f>& position,
                                                 const std::vector<char>& wanted) {
    std::vector<std::vector<std::uint32_t>> layers(grid.n[2] + 1);
    for (std::size_t p = 0; p < position.size(); ++p) {
        if (!wanted.empty() && !wanted[p]) continue;
        const int layer =
            finite(position[p]) ? on_axis(grid, 2, static_cast<int>(std::floor((position[p].z() - grid.origin.z()) / grid.cell.z()))) : -1;
        layers[layer < 0 ? grid.n[2] : layer].push_back(static_cast<std::uint32_t>(p));
    }
    return layers;
}

/// Weighted sums over particles, at the nodes.
struct Sums {
    const Frame& frame;
    const std::vector<Vec3f>& along;
    const std::vector<Eigen::Vector4f>& value;
    FlowGrid& grid;
    float h;  // m
    int reach[3];

    /// Adds a particle to the row (j, k) of nodes along x. @param away squared distance from the row [m^2]
    void add_to_row(std::uint32_t p, float away, int j, int k) {
        const float room = h * h - away;
        if (room <= 0) return;
        const float half = std::sqrt(room), x = frame.position[p].x() - grid.origin.x(), cell = grid.cell.x();
        int low = static_cast<int>(std::ceil((x - half) / cell)), high = static_cast<int>(std::floor((x + half) / cell));
        const int middle = static_cast<int>(std::floor(x / cell));
        low = std::max(low, middle - reach[0]), high = std::min(high, middle + reach[0]);
        for (int i = low; i <= high; ++i) {
            const int on = on_axis(grid, 0, i);
            if (on < 0) continue;
            const float dx = static_cast<float>(i) * cell - x, q = 1 - (away + dx * dx) / (h * h);
            if (q <= 0) continue;
            const float w = q * q;
            const std::size_t node = grid.index(on, j, k);
            grid.cover[node] += w;
            if (!along.empty()) grid.along[node] += w * along[p];
            if (!value.empty()) grid.value[node] += w * value[p];
        }
    }
    /// Adds a particle to the layer of nodes k, which lies dz [m] above it.
    void add_to_layer(std::uint32_t p, float dz, int k) {
        const float y = frame.position[p].y() - grid.origin.y(), cell = grid.cell.y();
        const int middle = static_cast<int>(std::floor(y / cell));
        for (int j = middle - reach[1]; j <= middle + reach[1]; ++j) {
            const int on = on_axis(grid, 1, j);
            if (on < 0) continue;
            const float dy = static_cast<float>(j) * cell - y;
            add_to_row(p, dz * dz + dy * dy, on, k);
        }
    }
};

}  // namespace

FlowGrid flow_grid(const Frame& frame, const std::vector<Vec3f>& along, const std::vector<Eigen::Vector4f>& value, std::size_t most_nodes,
                   float cell_in_spacings, float reach) {
    // Sum of the weights in a full lattice at a reach of 1.5 spacings: 4 pi (1/3 - 2/5 + 1/7) 1.5^3 in 3D, pi/3 1.5^2 in 2D.
    const float full = frame.dimensions == 2 ? 2.36f : 3.2f;
    FlowGrid grid = laid_out(frame, reach * frame.spacing, most_nodes, cell_in_spacings * frame.spacing);
    if (grid.n[0] == 0) return grid;
    const float h = std::max(reach * frame.spacing, 1.2f * grid.cell.maxCoeff());
    const float lattice = full * std::pow(h / (1.5f * frame.spacing), static_cast<float>(frame.dimensions));
    const std::size_t nodes = grid_count(grid.n[0], grid.n[1], grid.n[2]);
    if (!along.empty()) grid.along.assign(nodes, Vec3f::Zero());
    if (!value.empty()) grid.value.assign(nodes, Eigen::Vector4f::Zero());
    grid.cover.assign(nodes, 0);
    Sums sums{frame, along, value, grid, h, {}};
    // On a periodic axis shorter than the reach, a particle would be added to the same node twice.
    for (int a = 0; a < 3; ++a) {
        sums.reach[a] = static_cast<int>(std::ceil(h / grid.cell[a]));
        if (grid.periodic[a]) sums.reach[a] = std::min(sums.reach[a], (grid.n[a] - 1) / 2);
    }
    std::vector<char> wanted;
    if (along.empty() && !value.empty()) wanted = near_values(grid, h, frame.position, value);
    const std::vector<std::vector<std::uint32_t>> layers = by_layer(grid, frame.position, wanted);
    const std::size_t row = grid_count(grid.n[0], grid.n[1]);
    // Each layer of nodes gathers from the layers of particles around it, in ascending order.
    parallel_for(grid.n[2], [&](Index k) {
        for (int below = sums.reach[2]; below >= -sums.reach[2]; --below) {
            const int layer = on_axis(grid, 2, k - below);
            if (layer < 0) continue;
            for (const std::uint32_t p : layers[layer]) {
                float dz = static_cast<float>(k) * grid.cell.z() - (frame.position[p].z() - grid.origin.z());
                if (grid.periodic[2]) dz -= grid.extent().z() * std::nearbyint(dz / grid.extent().z());
                if (std::abs(dz) < h) sums.add_to_layer(p, dz, k);
            }
        }
        for (std::size_t m = k * row; m < (k + 1) * row; ++m) {
            const float weight = grid.cover[m];
            if (weight <= 0) continue;
            if (!along.empty()) grid.along[m] /= weight;
            if (!value.empty()) grid.value[m] /= weight;
            grid.cover[m] = std::min(1.0f, weight / lattice);
        }
    });
    return grid;
}

FlowGrid::Corners FlowGrid::corners(const Vec3f& x) const {
    int low[3], high[3];
    float share[3];
    for (int a = 0; a < 3; ++a) {
        const float position = (x[a] - origin[a]) / cell[a], floor = std::floor(position);
        share[a] = position - floor;
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
        if (c[0] < 0 || c[1] < 0 || c[2] < 0) continue;
        corners.node[corner] = index(c[0], c[1], c[2]);
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
        const std::size_t m = near.node[corner];
        const float w = near.weight[corner];
        sample.cover += w * cover[m];
        if (cover[m] <= 0) continue;  // no fluid here
        weights += w;
        if (!along.empty()) sample.along += w * along[m];
        if (!value.empty()) sample.value += w * value[m];
    }
    if (weights > 0) sample.along /= weights, sample.value /= weights;
    return sample;
}

}  // namespace whorl

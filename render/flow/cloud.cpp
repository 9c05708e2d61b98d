#include "render/flow/cloud.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr float least_density = 2e-3f;  // smaller densities count as 0, so that rays can skip them

/// Layers of nodes, stacked along the axis `main`. The axes a and b lie in a layer.
struct Layers {
    int main, a, b;
    std::size_t node(const FlowGrid& grid, int layer, int i, int j) const {
        int at[3];
        at[main] = layer, at[a] = i, at[b] = j;
        return grid.index(at[0], at[1], at[2]);
    }
};

void find_blocks(const FlowGrid& grid, const std::vector<float>& density, Cloud& cloud) {
    for (int axis = 0; axis < 3; ++axis) cloud.blocks[axis] = (grid.n[axis] + Cloud::block - 1) / Cloud::block;
    const std::array<int, 3> b = cloud.blocks;
    cloud.most.assign(grid_count(b[0], b[1], b[2]), 0);
    parallel_for(static_cast<Index>(cloud.most.size()), [&](Index m) {
        const int first[3] = {m % b[0] * Cloud::block, m / b[0] % b[1] * Cloud::block, m / (b[0] * b[1]) * Cloud::block};
        int low[3], high[3];
        for (int axis = 0; axis < 3; ++axis)
            low[axis] = std::max(0, first[axis] - 1), high[axis] = std::min(grid.n[axis] - 1, first[axis] + Cloud::block);
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) cloud.most[m] = std::max(cloud.most[m], density[grid.index(i, j, k)]);
    });
    // Distances to the nearest block that is not empty, from two sweeps over the blocks, each with the neighbours already visited.
    const auto count = static_cast<int>(cloud.most.size());
    constexpr float farthest = -1000;
    for (float& most : cloud.most)
        if (most <= 0) most = farthest;
    for (const int way : {1, -1})
        for (int m = way > 0 ? 0 : count - 1; m >= 0 && m < count; m += way) {
            if (cloud.most[m] > 0) continue;
            for (int side = 0; side < 13; ++side) {  // half of the 26 neighbours
                const int at[3] = {m % b[0] + way * (side % 3 - 1), m / b[0] % b[1] + way * (side / 3 % 3 - 1),
                                   m / (b[0] * b[1]) - way * (1 - side / 9)};
                if (at[0] < 0 || at[0] >= b[0] || at[1] < 0 || at[1] >= b[1] || at[2] < 0 || at[2] >= b[2]) continue;
                cloud.most[m] = std::max(cloud.most[m], std::min(0.0f, cloud.most[(at[2] * b[1] + at[1]) * b[0] + at[0]]) - 1);
            }
        }
}

/// The nodes with a density, and one more on each side.
NodeBox box_around(const FlowGrid& grid, const std::vector<float>& density) {
    NodeBox box{grid.n, {-1, -1, -1}};
    for (int k = 0; k < grid.n[2]; ++k)
        for (int j = 0; j < grid.n[1]; ++j)
            for (int i = 0; i < grid.n[0]; ++i) {
                if (!(density[grid.index(i, j, k)] > 0)) continue;
                const int at[3] = {i, j, k};
                for (int a = 0; a < 3; ++a) box.low[a] = std::min(box.low[a], at[a]), box.high[a] = std::max(box.high[a], at[a]);
            }
    for (int a = 0; a < 3; ++a) box.low[a] = std::max(box.low[a] - 1, 0), box.high[a] = std::min(box.high[a] + 1, grid.n[a] - 1);
    return box;
}

}  // namespace

std::vector<float> depth_towards(const FlowGrid& grid, const std::vector<float>& density, float thickness, const Vec3f& towards,
                                 const NodeBox& box) {
    std::vector<float> depth(density.size(), 0);
    Layers layers{0, 1, 2};
    towards.cwiseAbs().maxCoeff(&layers.main);
    layers.a = (layers.main + 1) % 3, layers.b = (layers.main + 2) % 3;
    const auto last_of = [&](int axis) { return std::min(box.high[axis], grid.n[axis] - 1); };
    const int first_a = box.low[layers.a], first_b = box.low[layers.b], end_a = last_of(layers.a) + 1, end_b = last_of(layers.b) + 1;
    const int na = end_a - first_a, nb = end_b - first_b, last = last_of(layers.main), first = box.low[layers.main];
    const bool up = towards[layers.main] > 0;
    const float layer_step = grid.cell[layers.main] / std::abs(towards[layers.main]);  // m, path of the light between two layers
    const float move_a = layer_step * towards[layers.a] / grid.cell[layers.a],
                move_b = layer_step * towards[layers.b] / grid.cell[layers.b];
    for (int count = 1; count <= last - first; ++count) {
        const int layer = up ? last - count : first + count, before = up ? layer + 1 : layer - 1;
        parallel_for(na * nb, [&](Index m) {
            const int i = first_a + m % na, j = first_b + m / na;
            const float x = static_cast<float>(i) + move_a, y = static_cast<float>(j) + move_b;
            const int i0 = static_cast<int>(std::floor(x)), j0 = static_cast<int>(std::floor(y));
            const float fx = x - static_cast<float>(i0), fy = y - static_cast<float>(j0);
            float ahead = 0, ahead_density = 0;
            for (int corner = 0; corner < 4; ++corner) {
                const int p = i0 + (corner & 1), q = j0 + (corner >> 1);
                if (p < first_a || q < first_b || p >= end_a || q >= end_b) continue;
                const float w = ((corner & 1) ? fx : 1 - fx) * ((corner >> 1) ? fy : 1 - fy);
                const std::size_t other = layers.node(grid, before, p, q);
                ahead += w * depth[other], ahead_density += w * density[other];
            }
            const std::size_t own = layers.node(grid, layer, i, j);
            depth[own] = ahead + layer_step * thickness * (density[own] + ahead_density) / 2;
        });
    }
    return depth;
}

std::vector<float> cloud_density(const FlowGrid& grid) {
    std::vector<float> density(grid.value.size());
    parallel_for(static_cast<Index>(density.size()), [&](Index m) {
        const float strength = grid.value[m][3];
        density[m] = grid.cover[m] * strength * strength;
    });
    return density;
}

Cloud lit_cloud(const FlowGrid& grid, float thickness, const CloudLight& light) {
    Cloud cloud;
    const auto nodes = static_cast<Index>(grid.value.size());
    if (nodes == 0) return cloud;
    std::vector<float> density = cloud_density(grid);
    for (float& dense : density)
        if (dense < least_density) dense = 0;
    find_blocks(grid, density, cloud);
    const NodeBox box = box_around(grid, density);
    const std::vector<float> to_lamp = depth_towards(grid, density, thickness, light.towards, box);
    std::vector<float> to_rim;
    if (!light.rim.isZero()) to_rim = depth_towards(grid, density, thickness, light.rim_towards, box);
    // The sky light comes from four directions, the corners of a regular tetrahedron. One of them is the direction of the lamp.
    const Vec3f w = light.towards, u = w.unitOrthogonal(), v = w.cross(u);
    std::vector<float> open(nodes, 0);
    for (const float turn : {0.0f, 1 / 3.0f, 2 / 3.0f}) {
        const float angle = 2 * std::numbers::pi_v<float> * turn;
        const Vec3f way = (0.94281f * (std::cos(angle) * u + std::sin(angle) * v) - w / 3).normalized();
        const std::vector<float> depth = depth_towards(grid, density, thickness, way, box);
        parallel_for(nodes, [&](Index m) {
            if (density[m] > 0) open[m] += std::exp(-depth[m]) / 4;
        });
    }
    cloud.lit.assign(nodes, Eigen::Vector4f::Zero());
    parallel_for(nodes, [&](Index m) {
        if (density[m] <= 0) return;
        const Vec3f colour = grid.value[m].head<3>() / grid.value[m][3];
        const float shade = std::exp(-to_lamp[m]);
        Vec3f falls = shade * light.lamp + (open[m] + shade / 4) * light.sky + Vec3f::Constant(light.glow);
        if (!to_rim.empty()) falls += std::exp(-to_rim[m]) * light.rim;
        cloud.lit[m].head<3>() = density[m] * colour.cwiseProduct(falls);
        cloud.lit[m][3] = density[m];
    });
    return cloud;
}

}  // namespace whorl

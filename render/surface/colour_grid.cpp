#include "render/surface/colour_grid.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Key of a block, from its position in blocks. Blocks in the order of their keys are in the order of an OpenVDB tree, in which meshes list
/// their vertices: by the bits from 9 on of all three coordinates, then by their bits 4 to 8, then by their bits 0 to 3.
using BlockKey = std::uint64_t;
constexpr int key_offset = 1 << 20;  // a million blocks in each direction

BlockKey key(const std::array<int, 3>& at) {
    BlockKey joined = 0;
    for (const auto& [shift, bits] : {std::pair(9, 12), {4, 5}, {0, 4}})
        for (const int one : at) joined = joined << bits | (static_cast<unsigned>(one + key_offset) >> shift & ((1u << bits) - 1));
    return joined;
}

std::array<int, 3> position_of(BlockKey key) {
    std::array<int, 3> at;
    for (int a = 0; a < 3; ++a) {
        const int c = 2 - a;
        at[a] = static_cast<int>((key >> (27 + 12 * c) & 4095) << 9 | (key >> (12 + 5 * c) & 31) << 4 | (key >> 4 * c & 15)) - key_offset;
    }
    return at;
}

/// All blocks with nodes that particles reach, or the next node, so that a surface never runs along a missing block. Ascending.
std::vector<BlockKey> touched_blocks(const ColourField& field, float voxel) {
    std::vector<BlockKey> touched;
    const float reach = field.reach() + voxel, block = voxel * block_edge;
    for (const ParticleRows::Bunch& bunch : field.particles().bunches(field.reach())) {
        const Eigen::Vector3i first = ((bunch.low.array() - reach) / block).floor().cast<int>(),
                              last = ((bunch.high.array() + reach) / block).floor().cast<int>();
        for (int a = first.x(); a <= last.x(); ++a)
            for (int b = first.y(); b <= last.y(); ++b)
                for (int c = first.z(); c <= last.z(); ++c) touched.push_back(key({a, b, c}));
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    return touched;
}

// Computes c at the block's nodes: each particle in turn adds its bump to the planes of nodes that it reaches.
void fill(const LocalField& local, float voxel, ColourBlock& block) {
    constexpr int plane_nodes = block_edge * block_edge;
    alignas(64) float colour[block_nodes] = {};
    for (std::size_t n = 0; n < local.x.size(); ++n) {
        const float inverse_R2 = voxel * voxel * local.inverse_R2[n], r = 1 / std::sqrt(inverse_R2);
        const float px = local.x[n] / voxel - static_cast<float>(block.origin[0]),
                    py = local.y[n] / voxel - static_cast<float>(block.origin[1]),
                    pz = local.z[n] / voxel - static_cast<float>(block.origin[2]);
        const int i0 = std::max(0, static_cast<int>(std::ceil(px - r))),
                  i1 = std::min(block_edge - 1, static_cast<int>(std::floor(px + r)));
        alignas(64) float aside[plane_nodes];  // (squared distance in the plane)/R^2
        for (int j = 0; j < block_edge; ++j) {
            const float dy = static_cast<float>(j) - py;
            for (int k = 0; k < block_edge; ++k) {
                const float dz = static_cast<float>(k) - pz;
                aside[j * block_edge + k] = inverse_R2 * (dy * dy + dz * dz);
            }
        }
        const float height = local.height[n];
        for (int i = i0; i <= i1; ++i) {
            const float dx = static_cast<float>(i) - px, rest = 1 - inverse_R2 * dx * dx;
            float* const plane = colour + i * plane_nodes;
            for (int m = 0; m < plane_nodes; ++m) {
                const float t = std::max(0.0f, rest - aside[m]);
                plane[m] += height * t * t * t;
            }
        }
    }
    std::copy(std::begin(colour), std::end(colour), block.value);
    block.least = *std::min_element(std::begin(colour), std::end(colour));
    block.most = *std::max_element(std::begin(colour), std::end(colour));
}

constexpr float deep = 0.9f;

// Whether the fluid fills the block, tested at every other node (64 of 512). With voxels of half a spacing no node is further than 0.87 d
// from a tested one, and the colour does not fall from 0.9 to 0.6 and rise again over that distance.
bool is_deep(const LocalField& local, const Vec3f& low, float voxel) {
    for (int i = 0; i < block_edge; i += 2)
        for (int j = 0; j < block_edge; j += 2)
            for (int k = 0; k < block_edge; k += 2)
                if (local.at(low + voxel * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k))).colour < deep)
                    return false;
    return true;
}

void cut_off(const Cut& cut, const LocalField& local, const Vec3f& low, float voxel, float iso, ColourBlock& block) {
    for (int n = 0; n < block_nodes; ++n) {
        const Vec3f x = low + voxel * ColourBlock::node(n);
        const float inside = cut.at(x).inside(x);
        if (cut.any_glass() && std::abs(inside) < local.wetting()) block.value[n] = local.at(x, cut, iso).colour;
        else block.value[n] = std::min(block.value[n], cut_colour(inside, iso, local.reach));
    }
    block.least = *std::min_element(block.value, block.value + block_nodes);
    block.most = *std::max_element(block.value, block.value + block_nodes);
}

}  // namespace

ColourGrid::ColourGrid(const ColourField& field, float voxel, const Cut& cut, float iso) : voxel_(voxel) {
    const std::vector<BlockKey> touched = touched_blocks(field, voxel);
    blocks_.resize(touched.size());
    values_ = std::make_unique_for_overwrite<float[]>(touched.size() * block_nodes);
    parallel_tasks(static_cast<Index>(blocks_.size()), [&](Index b) {
        ColourBlock& block = blocks_[b];
        const std::array<int, 3> at = position_of(touched[b]);
        for (int a = 0; a < 3; ++a) block.origin[a] = at[a] * block_edge;
        block.value = values_.get() + static_cast<std::size_t>(b) * block_nodes;
        for (int n = 0; n < 8; ++n) {
            const BlockKey wanted = key({at[0] + (n >> 2), at[1] + (n >> 1 & 1), at[2] + (n & 1)});
            const auto found = std::lower_bound(touched.begin(), touched.end(), wanted);
            block.ahead[n] = found == touched.end() || *found != wanted ? -1 : static_cast<Index>(found - touched.begin());
        }
        thread_local LocalField local;
        const Vec3f low = block.low(voxel), middle = block.middle(voxel);
        const float radius = ColourBlock::radius(voxel);
        const Cut near = cut.near(middle, radius, field.reach());
        if (near.any() &&
            near.at(middle).inside(middle) < -radius - voxel) {  // wholly beyond the cut, so no cell of the surface reaches it
            std::fill(block.value, block.value + block_nodes, 0.0f);
            block.least = block.most = 0;
            return;
        }
        local.gather(field, low, low.array() + voxel * (block_edge - 1), near.any_glass());
        if (voxel * 2 < 0.6f * local.reach && is_deep(local, low, voxel)) {
            std::fill(block.value, block.value + block_nodes, 1.0f);
            block.least = block.most = 1;
        } else {
            fill(local, voxel, block);
        }
        if (near.any()) cut_off(near, local, low, voxel, iso, block);
    });
}

}  // namespace whorl

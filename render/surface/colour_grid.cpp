#include "render/surface/colour_grid.h"

#include <openvdb/openvdb.h>

#include <cmath>
#include <unordered_map>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// Creates the blocks of all nodes that particles reach, and of one node more, so that a surface never runs along a missing block.
void touch_blocks(const ColourField& field, float voxel, openvdb::FloatTree::RootNodeType& root) {
    const float reach = field.reach() + voxel, block = voxel * block_edge;
    for (const ParticleRows::Bunch& bunch : field.particles().bunches(field.reach())) {
        const Eigen::Vector3i first = ((bunch.low.array() - reach) / block).floor().cast<int>(),
                              last = ((bunch.high.array() + reach) / block).floor().cast<int>();
        for (int a = first.x(); a <= last.x(); ++a)
            for (int b = first.y(); b <= last.y(); ++b)
                for (int c = first.z(); c <= last.z(); ++c) root.touchLeaf({a * block_edge, b * block_edge, c * block_edge});
    }
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

std::int64_t key(int a, int b, int c) {
    constexpr std::int64_t offset = 1 << 20;  // a million blocks in each direction
    return ((a + offset) << 42) | ((b + offset) << 21) | (c + offset);
}

}  // namespace

struct ColourGrid::Tree {
    /// The root node alone: OpenVDB's class of whole trees has virtual functions that take ten seconds to compile.
    openvdb::FloatTree::RootNodeType root{0.0f};
};

ColourGrid::ColourGrid(const ColourField& field, float voxel, const Cut& cut, float iso) : voxel_(voxel), tree_(std::make_unique<Tree>()) {
    touch_blocks(field, voxel, tree_->root);
    std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
    tree_->root.getNodes(leaves);
    std::unordered_map<std::int64_t, Index> index;
    blocks_.reserve(leaves.size());
    for (auto* leaf : leaves) {
        const openvdb::Coord& o = leaf->origin();
        index.emplace(key(o.x() / block_edge, o.y() / block_edge, o.z() / block_edge), static_cast<Index>(blocks_.size()));
        ColourBlock block;
        block.origin = {o.x(), o.y(), o.z()};
        block.value = leaf->buffer().data();
        blocks_.push_back(block);
    }
    parallel_tasks(static_cast<Index>(blocks_.size()), [&](Index b) {
        ColourBlock& block = blocks_[b];
        for (int n = 0; n < 8; ++n) {
            const auto found = index.find(key(block.origin[0] / block_edge + (n >> 2), block.origin[1] / block_edge + (n >> 1 & 1),
                                              block.origin[2] / block_edge + (n & 1)));
            block.ahead[n] = found == index.end() ? -1 : found->second;
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

ColourGrid::~ColourGrid() = default;

}  // namespace whorl

#pragma once
/// The colour field on the nodes of a grid that is fixed in the world: node (i, j, k) is at (i, j, k) voxel. Only blocks near particles
/// exist. An OpenVDB tree stores them.
#include <array>
#include <memory>
#include <vector>

#include "render/surface/colour_field.h"
#include "render/surface/ghosts.h"

namespace whorl {

/// Number of nodes along the edge of a block, and in a block.
inline constexpr int block_edge = 8, block_nodes = block_edge * block_edge * block_edge;

/// Leaf of the tree.
struct ColourBlock {
    std::array<int, 3> origin;  ///< index of the first node
    float* value;               ///< value of the block's node (i, j, k) at (8 i + j) 8 + k
    float least = 0, most = 0;
    /// Position of the first node [m].
    Vec3f low(float voxel) const {
        return voxel * Vec3f(static_cast<float>(origin[0]), static_cast<float>(origin[1]), static_cast<float>(origin[2]));
    }
    /// Middle of the block's cells [m], and the distance of their furthest corner from there [m].
    Vec3f middle(float voxel) const { return low(voxel).array() + 0.5f * voxel * block_edge; }
    static float radius(float voxel) { return 0.87f * voxel * block_edge; }
    /// Position of value[n] relative to the first node [voxels].
    static Vec3f node(int n) { return Vec3f(static_cast<float>(n >> 6), static_cast<float>(n >> 3 & 7), static_cast<float>(n & 7)); }
    std::array<Index, 8> ahead;  ///< index 4 a + 2 b + c: the block at origin + 8 (a, b, c); ahead[0]: itself; -1: none, all zero
};

class ColourGrid {
public:
    /// Blocks that lie wholly inside the fluid are set to 1 without evaluation. The colour is at most cut_colour().
    ColourGrid(const ColourField& field, float voxel, const Cut& cut = {}, float iso = 0);
    ~ColourGrid();

    float voxel() const { return voxel_; }  ///< m
    const std::vector<ColourBlock>& blocks() const { return blocks_; }

private:
    struct Tree;  ///< OpenVDB tree that stores the values
    float voxel_;
    std::unique_ptr<Tree> tree_;
    std::vector<ColourBlock> blocks_;
};

}  // namespace whorl

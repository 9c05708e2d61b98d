#pragma once
/// The colour field on the nodes of a grid that is fixed in the world: node (i, j, k) stands at (i, j, k) voxel. Only blocks near particles
/// exist; an OpenVDB tree holds them.
#include <array>
#include <memory>
#include <vector>

#include "render/surface/colour_field.h"
#include "render/surface/ghosts.h"

namespace whorl {

/// A leaf of the tree: 8^3 nodes.
struct ColourBlock {
    static constexpr int edge = 8;
    std::array<int, 3> origin;  ///< its first node
    float* value;               ///< of node (i, j, k) of the block at (8 i + j) 8 + k
    float least = 0, most = 0;
    std::array<Index, 8> ahead;  ///< the blocks at origin + 8 (a, b, c), at 4 a + 2 b + c (itself first); -1: no block, all zero
};

class ColourGrid {
public:
    /// Blocks that lie wholly inside the fluid are not computed but set to 1. At the sides of `cut` the colour falls through `iso`.
    ColourGrid(const ColourField& field, float voxel, const Cut& cut = {}, float iso = 0);
    ~ColourGrid();

    float voxel() const { return voxel_; }  ///< m
    const std::vector<ColourBlock>& blocks() const { return blocks_; }
    /// The tree, for colour_grid.cpp and vdb.cpp, which include OpenVDB.
    struct Tree;
    const Tree& tree() const { return *tree_; }

private:
    float voxel_;
    std::unique_ptr<Tree> tree_;
    std::vector<ColourBlock> blocks_;
};

}  // namespace whorl

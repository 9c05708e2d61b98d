#pragma once
/// Colour grid -> closed triangle mesh.
#include "engine/core/mesh.h"
#include "render/surface/colour_grid.h"

namespace whorl {

/// A mesh and which block of the grid each vertex came from (vertices of a block stand together).
struct MarchedMesh {
    TriangleMesh mesh;
    std::vector<Index> block;        ///< blocks with vertices, rising
    std::vector<Index> block_begin;  ///< of block[n] are the vertices block_begin[n] .. block_begin[n + 1]
};

/// The surface c = iso by marching cubes: closed and manifold always (every edge belongs to two triangles, every vertex to one fan).
MarchedMesh march(const ColourGrid& grid, float iso);

/// Moves every vertex onto c = iso of the field itself, which the grid only samples, and sets the normals from its gradient. Vertices on
/// the cut stay there.
void project(const ColourField& field, float iso, float voxel, const ColourGrid& grid, const Cut& cut, MarchedMesh& marched);

}  // namespace whorl

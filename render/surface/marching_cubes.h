#pragma once
/// Colour grid -> closed triangle mesh, by marching cubes (Lorensen and Cline 1987) with a computed table.
#include <array>
#include <cstdint>
#include <vector>

#include "engine/core/mesh.h"
#include "render/surface/colour_grid.h"

namespace whorl {

/// Corner n of a cell is at (n & 1, n >> 1 & 1, n >> 2 & 1). Cut edge e runs from a corner along an axis.
struct CubeEdge {
    int corner, axis;
};
/// The twelve edges of a cell. Edge 4 axis + n starts at the n-th of the four corners from which an edge runs along the axis.
const std::array<CubeEdge, 12>& cube_edges();

/// A polygon through cut edges, counter-clockwise seen from outside.
struct CubeLoop {
    std::vector<std::uint8_t> edge;
    /// Corner of the polygon from which a fan of triangles may spread; -1: only from a vertex in the middle of the cell. A diagonal between
    /// two edges of one face could also appear in the neighbouring cell, and four triangles would meet there.
    int fan = -1;
};

struct CubeCase {
    std::vector<CubeLoop> loops;
};
/// @param inside bit n: corner n is inside
const CubeCase& cube_case(unsigned inside);

/// A mesh and, for each vertex, the block of the grid that it came from (vertices of a block are contiguous).
struct MarchedMesh {
    TriangleMesh mesh;
    std::vector<Index> block;        ///< blocks with vertices, rising
    std::vector<Index> block_begin;  ///< block[n] has the vertices block_begin[n] .. block_begin[n + 1] - 1
    std::vector<float> bulk;         ///< per vertex, set by project(): 0 at a drop of radius 1.5 d, 0.6 at a flat surface
};

/// The surface c = iso by marching cubes, always closed and manifold: every edge belongs to two triangles, every vertex to one fan.
MarchedMesh march(const ColourGrid& grid, float iso);

/// Moves every vertex from the grid's approximation onto c = iso of the exact field, and sets the normals from its gradient. Vertices on
/// the cut stay there.
void project(const ColourField& field, float iso, float voxel, const ColourGrid& grid, const Cut& cut, MarchedMesh& marched);

}  // namespace whorl

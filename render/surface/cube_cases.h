#pragma once
/// Marching cubes (Lorensen and Cline 1987) with the table computed, not typed: how the surface cuts a cell, for each of the 256 patterns
/// of corners inside and outside.
#include <array>
#include <cstdint>
#include <vector>

namespace whorl {

/// Corner n of a cell stands at (n & 1, n >> 1 & 1, n >> 2 & 1). Cut edge e runs from a corner along an axis.
struct CubeEdge {
    int corner, axis;
};
/// The twelve edges, number 4 axis + (the corner's place among the four).
const std::array<CubeEdge, 12>& cube_edges();

/// A polygon through cut edges, counter-clockwise seen from outside.
struct CubeLoop {
    std::vector<std::uint8_t> edge;
    /// Corner of the polygon from which a fan of triangles may spread, -1: only from a vertex in the middle of the cell. A diagonal between
    /// two edges of one face of the cell could appear in the neighbour as well, and four triangles would meet there.
    int fan = -1;
};

struct CubeCase {
    std::vector<CubeLoop> loops;
};
/// @param inside bit n: corner n is inside
const CubeCase& cube_case(unsigned inside);

}  // namespace whorl

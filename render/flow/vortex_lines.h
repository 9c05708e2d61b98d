#pragma once
/// Lines along the vorticity, as tubes or ribbons.
#include <cstdint>
#include <vector>

#include "render/flow/flow_grid.h"

namespace whorl {

/// Triangles with normals.
struct VortexLines {
    std::vector<Vec3f> position;  ///< m
    std::vector<Vec3f> normal;
    std::vector<Vec3f> colour;  ///< linear RGB
    std::vector<float> light;   ///< of the lamp that comes through the other lines, 0 .. 1
    std::vector<std::uint32_t> index;
};

struct LineShape {
    int seeds = 400;              ///< spread evenly over the fluid
    float width = 0;              ///< m, of a tube where the field is strongest; a ribbon is 2.5 times as wide
    float length = 0;             ///< m, of a line to each side of its seed at most
    bool flat = false;            ///< ribbons, which turn as the neighbouring lines do
    float thickness = 0;          ///< optical depth of a metre of the strongest field, for the light
    Vec3f lamp = Vec3f::UnitY();  ///< towards it, unit length
};

/// A line through each of the `seeds` particles with the lowest "grain", or with the lowest index where particles have no grain: the same
/// particles from frame to frame. Vortex lines move with the fluid (Helmholtz), so the lines do not jump. A line ends where the field is
/// weak, where the fluid ends, or where it comes back to its seed; it is thin where the field is weak.
/// @param grid with vorticity, and as values the colour times the strength, and the strength (0 .. 1)
VortexLines vortex_lines(const Frame& frame, const FlowGrid& grid, const LineShape& shape);

/// Ribbons that face the eye, wide at the particle, nothing at the end; as triangles.
struct Trails {
    std::vector<Vec3f> position;  ///< m
    std::vector<Vec3f> colour;    ///< of the particle, a corner
    std::vector<std::uint32_t> index;
};

/// Each particle's way back over `seconds` through the grid's flow, its velocity (midpoint rule), in pieces. A moment's flow, not the
/// particle's history: a resumed film draws the same, and in steady vortices both are the same. @param width at the particle [m]
Trails trails(const Frame& frame, const std::vector<Vec3f>& colour, const FlowGrid& grid, float seconds, float width, const Vec3f& eye);

}  // namespace whorl

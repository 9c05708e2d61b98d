#pragma once
/// Meshes of vortex lines, as tubes or ribbons, and of the trails of particles.
#include <cstdint>
#include <vector>

#include "render/flow/flow_grid.h"

namespace whorl {

/// Triangles with normals.
struct VortexLines {
    std::vector<Vec3f> position;  ///< m
    std::vector<Vec3f> normal;
    std::vector<Vec3f> colour;  ///< linear RGB
    std::vector<float> light;   ///< share of the light of the lamp that the other lines let through, 0 .. 1
    std::vector<std::uint32_t> index;
};

struct LineShape {
    int seeds = 400;              ///< number of lines, spread evenly over the fluid
    float width = 0;              ///< m, width of a tube where the field is strongest; a ribbon is 2.5 times as wide
    float length = 0;             ///< m, largest length of a line to each side of its seed
    bool flat = false;            ///< true: ribbons, which twist with the neighbouring lines; false: tubes
    float thickness = 0;          ///< optical depth per metre of the strongest field, for VortexLines::light
    Vec3f lamp = Vec3f::UnitY();  ///< direction to the lamp, unit vector
};

/// Lines along the vorticity, one through each of the `seeds` particles with the lowest "grain" (with the lowest index if the frame has no
/// "grain"). These are the same particles in every frame. Vortex lines move with the fluid (Helmholtz), so the lines do not jump. A line is
/// thin where the field is weak. It ends where the strength is below 0.1, where the fluid ends, or where it returns to its seed.
/// @param grid with the vorticity as FlowGrid::along, and colour times strength (linear RGB) and strength (0 .. 1) as its values
VortexLines vortex_lines(const Frame& frame, const FlowGrid& grid, const LineShape& shape);

/// Triangles of ribbons that face the eye and taper from the particle to a point.
struct Trails {
    std::vector<Vec3f> position;  ///< m
    std::vector<Vec3f> colour;    ///< linear RGB per position, that of the particle
    std::vector<std::uint32_t> index;
};

/// Trail behind each particle: its path over the past `seconds` in the grid's velocity field (midpoint rule, six steps). The field is that
/// of this frame, not the particle's history, so a resumed run draws the same trails. In a steady flow the trail is the history.
/// @param width at the particle [m] @param eye position of the camera [m]
Trails trails(const Frame& frame, const std::vector<Vec3f>& colour, const FlowGrid& grid, float seconds, float width, const Vec3f& eye);

}  // namespace whorl

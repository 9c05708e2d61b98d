#pragma once
/// Trails behind particles: where the flow of this moment would have brought them from.
#include "render/flow/flow_grid.h"

namespace whorl {

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

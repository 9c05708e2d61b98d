#pragma once
/// A plane through the flow as a picture: the field's colours, streaked along the flow.
#include "render/flow/flow_grid.h"
#include "render/look/look_options.h"

namespace whorl {

struct FlowSlice {
    Vec3f corner = Vec3f::Zero(), across = Vec3f::Zero(), up = Vec3f::Zero();  ///< m; the picture's first pixel, and its sides
    int width = 0, height = 0;
    std::vector<float> rgba;  ///< linear light, four floats a pixel, rows from the corner on; alpha: the fluid's cover

    bool empty() const { return rgba.empty(); }
};

/// Where the look's slice stands on its axis [m]: as given, else in the middle of the fluid.
float slice_position(const FlowGrid& grid, const LookOptions& look);
/// @param grid with the field's values as 0 .. 1 along the colour map @param longest side of the picture [pixels]
FlowSlice flow_slice(const FlowGrid& grid, const LookOptions& look, int longest);

}  // namespace whorl

#pragma once
/// A plane through the flow as a picture: the field's colours, streaked along the flow.
#include <array>
#include <vector>

#include "render/flow/plane_field.h"
#include "render/look/look_options.h"

namespace whorl {

struct FlowSlice {
    PixelPlane plane;
    std::vector<float> rgba;  ///< linear light, four floats a pixel, rows from the corner on; alpha: the fluid's cover

    bool empty() const { return rgba.empty(); }
};

/// How much of a pixel is drawn as fluid. @param weight PlaneField's cover
float flow_cover(float weight);
/// The plane of the look's slice through the domain, in pixels. @param longest pixels of the longer side. Seen from the positive end of its
/// axis.
PixelPlane slice_plane(const Frame& frame, const LookOptions& look, int longest);
/// @param range of the colour map @param ground linear RGB of the ground under inks
FlowSlice flow_slice(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, const PixelPlane& plane,
                     const Vec3f& ground);

struct SolidSection {
    bool container = false;      ///< the fluid is inside the outline
    std::vector<float> inside;   ///< share of each pixel that lies within the outline, rows from below; empty if the plane misses it
    std::vector<float> outline;  ///< share of each pixel that its line covers
};

/// @param line width of the outline [pixels]
std::vector<SolidSection> section_solids(const Frame& frame, const PixelPlane& plane, float line);

}  // namespace whorl

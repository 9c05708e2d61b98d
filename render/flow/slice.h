#pragma once
/// Colours of a plane through the flow: those of the field, with streaks along the flow and other marks.
#include <array>
#include <vector>

#include "render/flow/plane_field.h"
#include "render/look/look_options.h"

namespace whorl {

struct FlowSlice {
    PixelPlane plane;
    std::vector<float> rgba;  ///< linear light, four floats per pixel, rows from the plane's corner; alpha: drawn share of fluid

    bool empty() const { return rgba.empty(); }
};

/// Share of a pixel that is drawn as fluid, 0 .. 1. @param weight PlaneField's cover
float flow_cover(float weight);
/// Plane of the look's slice through the domain, seen from the positive end of its axis. @param longest number of pixels of the longer side
PixelPlane slice_plane(const Frame& frame, const LookOptions& look, int longest);
/// Colours of the fluid in a plane. @param range of the colour map @param ground colour under inks, linear RGB
FlowSlice flow_slice(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, const PixelPlane& plane,
                     const Vec3f& ground);

/// Section of a solid, per pixel of a plane, rows from below.
struct SolidSection {
    bool container = false;      ///< the fluid is inside the outline
    std::vector<float> inside;   ///< share of the pixel inside the outline, 0 .. 1
    std::vector<float> outline;  ///< share of the pixel that the line of the outline covers, 0 .. 1
};

/// Sections of the solids that the plane cuts. @param line width of the outline [pixels]
std::vector<SolidSection> section_solids(const Frame& frame, const PixelPlane& plane, float line);

}  // namespace whorl

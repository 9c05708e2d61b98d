#pragma once
/// Colours of a plane through the flow: those of the field, with streaks along the flow and other marks.
#include <array>
#include <optional>
#include <vector>

#include "render/flow/plane_field.h"
#include "render/image/image.h"
#include "render/look/look_options.h"

namespace whorl {

struct FlowSlice {
    PixelPlane plane;
    std::vector<float> rgba;  ///< linear light, four floats per pixel, rows from the plane's corner; alpha: drawn share of fluid

    bool empty() const { return rgba.empty(); }
};

/// Share of a pixel that is drawn as fluid, 0 .. 1. @param weight PlaneField's cover
float flow_cover(float weight);
/// Plane of the look's slice through a box, seen from the positive end of its axis. @param longest number of pixels of the longer side
/// @param box that bounds the plane; none: the domain
PixelPlane slice_plane(const Frame& frame, const LookOptions& look, int longest, const std::optional<ShownBox>& box = {});
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

/// Image of a slice as in a printed figure: seen face-on, as large as the image allows, solids in one tone with an outline, text in a
/// margin. @param range of the colour map @param size width and height of the image [pixels] @param box as in slice_plane()
Image draw_slice_image(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, const std::array<int, 2>& size,
                       const std::optional<ShownBox>& box = {});

/// Difference of a field, `other` minus `one`, on a diverging map, in the pixels that have fluid in both frames. Of inks: the first.
/// @param look of `one`, which selects the field; title and legend describe the difference @param range of the difference
/// @param size, box as above
Image draw_difference_plate(const Frame& one, const Frame& other, const LookOptions& look, const std::array<float, 2>& range,
                            const std::array<int, 2>& size, const std::optional<ShownBox>& box = {});
/// 99th percentile of the finite values' magnitudes; 0 without values.
float usual_size(std::vector<float> values);
/// usual_size() of the difference over the fluid, on a plane of 160 pixels along its longer side; 0 without fluid.
float usual_difference(const Frame& one, const Frame& other, const LookOptions& look);

}  // namespace whorl

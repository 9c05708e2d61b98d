#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/flow/slice.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"
#include "render/look/overlay.h"

namespace whorl {
namespace {

/// Linear greys outside the fluid: white paper, or black.
struct Tones {
    float paper, solid, outline;
};
Tones tones_of(const LookOptions& look) { return look.background == "dark" ? Tones{0.0f, 0.07f, 0.35f} : Tones{1.0f, 0.42f, 0.06f}; }

void lay(Vec3f& colour, float tone, float share) { colour += share * (Vec3f::Constant(tone) - colour); }

/// @param slice_in function that returns the FlowSlice of a plane on a ground of a colour
template <class SliceIn>
Image plate(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, const std::array<int, 2>& size,
            const std::optional<ShownBox>& box, const SliceIn& slice_in) {
    const auto [width, height] = size;
    const Tones tones = tones_of(look);
    const PixelPlane whole = slice_plane(frame, look, 4096, box);
    const Layout layout = layout_of(width, height, static_cast<float>(whole.width) / static_cast<float>(whole.height), look, range);
    PixelPlane plane = whole;
    plane.width = layout.flow.width, plane.height = layout.flow.height;
    plane.pixel = whole.pixel * static_cast<float>(whole.width) / static_cast<float>(plane.width);
    const FlowSlice flow = slice_in(plane, Vec3f::Constant(tones.paper));
    const std::vector<SolidSection> solids = section_solids(frame, plane, std::max(1.2f, 0.16f * layout.text));

    Image image = plain_image(width, height, srgb_byte(tones.paper));
    parallel_for(plane.height, [&](Index row) {
        for (int x = 0; x < plane.width; ++x) {
            const std::size_t k = grid_index(x, static_cast<int>(row), plane.width);
            Vec3f colour = Vec3f::Constant(tones.paper);
            const float cover = flow.rgba[4 * k + 3];
            for (int c = 0; c < 3; ++c) colour[c] += cover * (flow.rgba[4 * k + c] - colour[c]);
            for (const SolidSection& solid : solids) {
                if (!solid.container) lay(colour, tones.solid, solid.inside[k]);
                lay(colour, tones.outline, solid.outline[k]);
            }
            // A thin line round the flow marks its edge on the paper.
            const bool rim = x == 0 || row == 0 || x + 1 == plane.width || row + 1 == plane.height;
            if (rim) lay(colour, tones.outline, 0.5f);
            std::uint8_t* pixel = image.pixel(layout.flow.x + x, layout.flow.y + plane.height - 1 - static_cast<int>(row));
            for (int c = 0; c < 3; ++c) pixel[c] = srgb_byte(colour[c]);
        }
    });
    draw_words(image, layout, look, range, frame.time);
    return image;
}

std::vector<float> values_of(const Frame& frame, const LookOptions& look) {
    if (look.field != "ink") return field_values(frame, look);
    std::vector<float> values(frame.position.size(), 0.0f);
    if (const auto ink = frame.vector.find("ink"); ink != frame.vector.end())
        for (std::size_t p = 0; p < values.size(); ++p) values[p] = ink->second[p][0];
    return values;
}

/// Field of `other` minus field of `one`, with the smaller cover of both, in the pixels of a plane.
PlaneField difference_field(const Frame& one, const Frame& other, const LookOptions& look, const PixelPlane& plane) {
    const PlaneField first = plane_field(one, {values_of(one, look)}, plane);
    PlaneField field = plane_field(other, {values_of(other, look)}, plane);
    for (std::size_t k = 0; k < field.cover.size(); ++k) {
        field.value[0][k] -= first.value[0][k];
        field.cover[k] = std::min(field.cover[k], first.cover[k]);
    }
    return field;
}

}  // namespace

Image draw_slice_image(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, const std::array<int, 2>& size,
                       const std::optional<ShownBox>& box) {
    return plate(frame, look, range, size, box,
                 [&](const PixelPlane& plane, const Vec3f& ground) { return flow_slice(frame, look, range, plane, ground); });
}

Image draw_difference_plate(const Frame& one, const Frame& other, const LookOptions& look, const std::array<float, 2>& range,
                            const std::array<int, 2>& size, const std::optional<ShownBox>& box) {
    LookOptions shown = look;
    shown.colour_map = "coolwarm";
    if (shown.field == "ink") shown.legend = false;
    return plate(one, shown, range, size, box, [&](const PixelPlane& plane, const Vec3f&) {
        const PlaneField field = difference_field(one, other, look, plane);
        const ColourTable colours(shown.colour_map);
        FlowSlice slice{plane, std::vector<float>(4 * field.cover.size())};
        for (std::size_t k = 0; k < field.cover.size(); ++k) {
            const Vec3f colour = colours((field.value[0][k] - range[0]) / (range[1] - range[0]));
            for (int c = 0; c < 3; ++c) slice.rgba[4 * k + c] = colour[c];
            slice.rgba[4 * k + 3] = flow_cover(field.cover[k]);
        }
        return slice;
    });
}

float usual_size(std::vector<float> values) {
    std::erase_if(values, [](float v) { return !std::isfinite(v); });
    if (values.empty()) return 0;
    for (float& v : values) v = std::abs(v);
    const auto usual = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
    std::nth_element(values.begin(), usual, values.end());
    return *usual;
}

float usual_difference(const Frame& one, const Frame& other, const LookOptions& look) {
    const PlaneField field = difference_field(one, other, look, slice_plane(one, look, 160));
    std::vector<float> values;
    for (std::size_t k = 0; k < field.cover.size(); ++k)
        if (field.cover[k] > 0.5f) values.push_back(field.value[0][k]);
    return usual_size(std::move(values));
}

}  // namespace whorl

#include "render/flow/plate.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/flow/difference_field.h"
#include "render/flow/solid_cut.h"
#include "render/image/linear_light.h"
#include "render/look/overlay.h"

namespace whorl {
namespace {

/// Linear greys of what is not fluid: white paper, or black.
struct Tones {
    float paper, solid, outline;
};
Tones tones_of(const LookOptions& look) { return look.background == "dark" ? Tones{0.0f, 0.07f, 0.35f} : Tones{1.0f, 0.42f, 0.06f}; }

void lay(Vec3f& colour, float tone, float share) { colour += share * (Vec3f::Constant(tone) - colour); }

/// @param slice_in of a plane in the flow: its FlowSlice
template <class SliceIn>
Image plate(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, int width, int height,
            const SliceIn& slice_in) {
    const Tones tones = tones_of(look);
    const PixelPlane whole = slice_plane(frame, look, 4096);
    const Layout layout = layout_of(width, height, static_cast<float>(whole.width) / static_cast<float>(whole.height), look, range);
    PixelPlane plane = whole;
    plane.width = layout.flow.width, plane.height = layout.flow.height;
    plane.pixel = whole.pixel * static_cast<float>(whole.width) / static_cast<float>(plane.width);
    const FlowSlice flow = slice_in(plane, Vec3f::Constant(tones.paper));
    const std::vector<SolidCut> solids = cut_solids(frame, plane, std::max(1.2f, 0.16f * layout.text));

    Image image = plain_image(width, height, srgb_byte(tones.paper));
    parallel_for(plane.height, [&](Index row) {
        for (int x = 0; x < plane.width; ++x) {
            const std::size_t k = grid_index(x, static_cast<int>(row), plane.width);
            Vec3f colour = Vec3f::Constant(tones.paper);
            const float cover = flow.rgba[4 * k + 3];
            for (int c = 0; c < 3; ++c) colour[c] += cover * (flow.rgba[4 * k + c] - colour[c]);
            for (const SolidCut& solid : solids) {
                if (!solid.container) lay(colour, tones.solid, solid.inside[k]);
                lay(colour, tones.outline, solid.outline[k]);
            }
            // A thin line round the flow, which else has no edge on paper.
            const bool rim = x == 0 || row == 0 || x + 1 == plane.width || row + 1 == plane.height;
            if (rim) lay(colour, tones.outline, 0.5f);
            std::uint8_t* pixel = image.pixel(layout.flow.x + x, layout.flow.y + plane.height - 1 - static_cast<int>(row));
            for (int c = 0; c < 3; ++c) pixel[c] = srgb_byte(colour[c]);
        }
    });
    draw_words(image, layout, look, range, frame.time);
    return image;
}

}  // namespace

Image draw_plate(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, int width, int height) {
    return plate(frame, look, range, width, height,
                 [&](const PixelPlane& plane, const Vec3f& ground) { return flow_slice(frame, look, range, plane, ground); });
}

Image draw_difference_plate(const Frame& one, const Frame& other, const LookOptions& look, const std::array<float, 2>& range, int width,
                            int height) {
    LookOptions shown = look;
    shown.colour_map = "coolwarm";
    if (shown.field == "ink") shown.legend = false;
    return plate(one, shown, range, width, height, [&](const PixelPlane& plane, const Vec3f&) {
        return coloured(difference_field(one, other, look, plane), "coolwarm", range);
    });
}

float usual_difference(const Frame& one, const Frame& other, const LookOptions& look) {
    const DifferenceField field = difference_field(one, other, look, slice_plane(one, look, 160));
    std::vector<float> sizes;
    for (std::size_t k = 0; k < field.value.size(); ++k)
        if (field.cover[k] > 0.5f) sizes.push_back(std::abs(field.value[k]));
    if (sizes.empty()) return 0;
    const auto usual = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 99 / 100);
    std::nth_element(sizes.begin(), usual, sizes.end());
    return *usual;
}

}  // namespace whorl

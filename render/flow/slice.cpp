#include "render/flow/slice.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/flow/marks.h"
#include "render/flow/streaks.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"
#include "render/look/pigments.h"

namespace whorl {
namespace {

/// Where the slice stands on its axis [m]: as given, else in the middle of the fluid.
float slice_position(const Frame& frame, const LookOptions& look, int axis) {
    if (look.slice_position) return *look.slice_position;
    float low = 1e30f, high = -1e30f;
    for (const Vec3f& x : frame.position)
        if (std::isfinite(x[axis])) low = std::min(low, x[axis]), high = std::max(high, x[axis]);
    return low <= high && frame.dimensions == 3 ? 0.5f * (low + high) : 0.5f * (frame.domain_min[axis] + frame.domain_max[axis]);
}

/// The way that streaks and arrows show to each side [s]: as chosen for the film, else what the fastest needs.
float way_shown(const PlaneField& field, const LookOptions& look, const PixelPlane& plane) {
    if (look.streak_time > 0) return look.streak_time;
    float fastest = 0;
    for (std::size_t k = 0; k < field.cover.size(); ++k)
        fastest = std::max(fastest, std::hypot(field.velocity[0][k], field.velocity[1][k]));
    const float size = static_cast<float>(std::max(plane.width, plane.height)) * plane.pixel;
    return fastest > 0 ? size * (look.streaks ? 1.0f / 45 : arrow_reach / static_cast<float>(look.arrows)) / fastest : 0;
}

/// What the look lays over the colours; what it does not ask for is empty.
struct SliceMarks {
    std::vector<float> streak, light, line;
    Arrows arrow;

    void lay_on(Vec3f& colour, Index k) const {
        constexpr float dark = 0.012f, pale = 0.8f;  // linear greys
        if (!streak.empty()) colour *= std::exp(0.2f * std::clamp(streak[k], -2.0f, 2.0f));
        if (!light.empty()) colour *= light[k];
        if (!line.empty()) colour += 0.75f * line[k] * (Vec3f::Constant(dark) - colour);
        if (arrow.body.empty()) return;
        colour += 0.6f * arrow.halo[k] * (Vec3f::Constant(pale) - colour);
        colour += arrow.body[k] * (Vec3f::Constant(dark) - colour);
    }
};

SliceMarks marks_of(const PlaneField& field, const LookOptions& look, const std::array<float, 2>& range, bool inked,
                    const PixelPlane& plane) {
    SliceMarks marks;
    const float seconds = look.streaks || look.arrows > 0 ? way_shown(field, look, plane) : 0;
    if (look.streaks && seconds > 0) marks.streak = streaks(field, seconds, plane.pixel);
    if (look.arrows > 0 && seconds > 0) marks.arrow = arrows(field, look.arrows, seconds, plane.pixel);
    if (look.relief <= 0 && look.isolines == 0) return marks;
    std::vector<float> value = field.value[0];
    for (int n = 1; inked && n < 3; ++n)  // of inks: how much of all
        for (std::size_t k = 0; k < value.size(); ++k) value[k] += field.value[n][k];
    if (look.relief > 0) marks.light = relief(field, value, range, look.relief);
    if (look.isolines > 0) marks.line = iso_lines(field, value, range, look.isolines);
    return marks;
}

}  // namespace

float flow_cover(float weight) { return std::clamp((weight - 0.25f) / 0.15f, 0.0f, 1.0f); }

PixelPlane slice_plane(const Frame& frame, const LookOptions& look, int longest) {
    const int axis = look.slice_axis == "x" ? 0 : look.slice_axis == "y" ? 1 : 2;
    PixelPlane plane;
    plane.right = axis == 0 ? Vec3f(-Vec3f::UnitZ()) : Vec3f(Vec3f::UnitX());
    plane.up = axis == 1 ? Vec3f(-Vec3f::UnitZ()) : Vec3f(Vec3f::UnitY());
    const Vec3f size = frame.domain_max - frame.domain_min;
    const float wide = std::abs(size.dot(plane.right)), tall = std::abs(size.dot(plane.up));
    plane.pixel = std::max(wide, tall) / static_cast<float>(longest);
    plane.width = std::max(1, static_cast<int>(std::lround(wide / plane.pixel)));
    plane.height = std::max(1, static_cast<int>(std::lround(tall / plane.pixel)));
    for (int a = 0; a < 3; ++a) plane.corner[a] = plane.right[a] + plane.up[a] < 0 ? frame.domain_max[a] : frame.domain_min[a];
    plane.corner[axis] = frame.dimensions == 2 ? 0 : slice_position(frame, look, axis);
    return plane;
}

FlowSlice flow_slice(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, const PixelPlane& plane,
                     const Vec3f& ground) {
    FlowSlice slice{plane, {}};
    const bool inked = look.field == "ink";
    std::vector<std::vector<float>> value(inked ? 3 : 1);
    if (inked) {
        const auto ink = frame.vector.find("ink");
        for (int k = 0; k < 3; ++k)
            for (std::size_t p = 0; p < frame.position.size(); ++p)
                value[k].push_back(ink == frame.vector.end() ? 0.0f : ink->second[p][k]);
    } else {
        value[0] = field_values(frame, look);
    }
    const PlaneField field = plane_field(frame, value, plane);
    const SliceMarks marks = marks_of(field, look, inked ? std::array<float, 2>{0, 1} : range, inked, plane);
    const ColourTable colours(look.colour_map);
    const Pigments pigments(look.inks.of, ground);
    slice.rgba.resize(4 * field.cover.size());
    parallel_for(static_cast<Index>(field.cover.size()), [&](Index k) {
        Vec3f colour;
        if (inked) colour = pigments(Vec3f(field.value[0][k], field.value[1][k], field.value[2][k]).cwiseMax(0.0f).cwiseMin(1.0f));
        else colour = colours((field.value[0][k] - range[0]) / (range[1] - range[0]));
        marks.lay_on(colour, k);
        for (int c = 0; c < 3; ++c) slice.rgba[4 * k + c] = colour[c];
        slice.rgba[4 * k + 3] = flow_cover(field.cover[k]);
    });
    return slice;
}

}  // namespace whorl

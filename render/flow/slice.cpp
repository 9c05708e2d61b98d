#include "render/flow/slice.h"

#include <algorithm>
#include <cmath>

#include "engine/core/grid_index.h"
#include "engine/core/parallel.h"
#include "render/flow/marks.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"
#include "render/look/material.h"

namespace whorl {
namespace {

/// Position of the slice on its axis [m]: the look's, or the middle of the fluid if it is not set.
float slice_position(const Frame& frame, const LookOptions& look, int axis) {
    if (look.slice_position) return *look.slice_position;
    float low = 1e30f, high = -1e30f;
    for (const Vec3f& x : frame.position)
        if (std::isfinite(x[axis])) low = std::min(low, x[axis]), high = std::max(high, x[axis]);
    return low <= high && frame.dimensions == 3 ? 0.5f * (low + high) : 0.5f * (frame.domain_min[axis] + frame.domain_max[axis]);
}

/// Flow time that streaks and arrows cover upstream and downstream [s]: the look's, or chosen by the fastest flow if it is not set.
float shown_time(const PlaneField& field, const LookOptions& look, const PixelPlane& plane) {
    if (look.streak_time > 0) return look.streak_time;
    float fastest = 0;
    for (std::size_t k = 0; k < field.cover.size(); ++k)
        fastest = std::max(fastest, std::hypot(field.velocity[0][k], field.velocity[1][k]));
    const float size = static_cast<float>(std::max(plane.width, plane.height)) * plane.pixel;
    return fastest > 0 ? size * (look.streaks ? 1.0f / 45 : arrow_reach / static_cast<float>(look.arrows)) / fastest : 0;
}

/// Marks over the colours, per pixel. Those that the look does not request are empty.
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
    const float seconds = look.streaks || look.arrows > 0 ? shown_time(field, look, plane) : 0;
    if (look.streaks && seconds > 0) marks.streak = streaks(field, seconds, plane.pixel);
    if (look.arrows > 0 && seconds > 0) marks.arrow = arrows(field, look.arrows, seconds, plane.pixel);
    if (look.relief <= 0 && look.isolines == 0) return marks;
    std::vector<float> value = field.value[0];
    for (int n = 1; inked && n < 3; ++n)  // inks: the sum of their concentrations
        for (std::size_t k = 0; k < value.size(); ++k) value[k] += field.value[n][k];
    if (look.relief > 0) marks.light = relief(field, value, range, look.relief);
    if (look.isolines > 0) marks.line = iso_lines(field, value, range, look.isolines);
    return marks;
}

/// Values f(inks) of the points, interpolated in the pixels. So only inks of one point mix as pigments; adjacent points of different inks
/// show both colours.
template <class F>
std::array<std::vector<float>, 3> inks_in(const Frame& frame, const PixelPlane& plane, const F& f) {
    const Frame points = inked_points(frame);
    const auto ink = points.vector.find("ink");
    std::vector<std::vector<float>> value(3);
    for (std::size_t p = 0; p < points.position.size(); ++p) {
        const Vec3f shown = f(ink == points.vector.end() ? Vec3f(Vec3f::Zero()) : Vec3f(ink->second[p].cwiseMax(0.0f).cwiseMin(1.0f)));
        for (int k = 0; k < 3; ++k) value[k].push_back(shown[k]);
    }
    return plane_field(points, value, plane, true).value;
}

}  // namespace

float flow_cover(float weight) { return std::clamp((weight - 0.25f) / 0.15f, 0.0f, 1.0f); }

PixelPlane slice_plane(const Frame& frame, const LookOptions& look, int longest, const std::optional<ShownBox>& box) {
    const int axis = look.slice_axis == "x" ? 0 : look.slice_axis == "y" ? 1 : 2;
    PixelPlane plane;
    plane.right = axis == 0 ? Vec3f(-Vec3f::UnitZ()) : Vec3f(Vec3f::UnitX());
    plane.up = axis == 1 ? Vec3f(-Vec3f::UnitZ()) : Vec3f(Vec3f::UnitY());
    const ShownBox shown = box.value_or(ShownBox{frame.domain_min, frame.domain_max});
    const Vec3f size = shown[1] - shown[0];
    const float wide = std::abs(size.dot(plane.right)), tall = std::abs(size.dot(plane.up));
    plane.pixel = std::max(wide, tall) / static_cast<float>(longest);
    plane.width = std::max(1, static_cast<int>(std::lround(wide / plane.pixel)));
    plane.height = std::max(1, static_cast<int>(std::lround(tall / plane.pixel)));
    for (int a = 0; a < 3; ++a) plane.corner[a] = shown[plane.right[a] + plane.up[a] < 0 ? 1 : 0][a];
    plane.corner[axis] = frame.dimensions == 2 ? 0 : slice_position(frame, look, axis);
    return plane;
}

FlowSlice flow_slice(const Frame& frame, const LookOptions& look, const std::array<float, 2>& range, const PixelPlane& plane,
                     const Vec3f& ground) {
    FlowSlice slice{plane, {}};
    const bool inked = look.field == "ink";
    std::vector<std::vector<float>> value;
    if (!inked) value.push_back(field_values(frame, look));
    PlaneField field = plane_field(frame, value, plane);
    if (inked && (look.relief > 0 || look.isolines > 0)) field.value = inks_in(frame, plane, [](const Vec3f& c) { return c; });
    const SliceMarks marks = marks_of(field, look, inked ? std::array<float, 2>{0, 1} : range, inked, plane);
    const ColourTable colours(look.colour_map);
    if (inked) field.value = inks_in(frame, plane, Pigments(look.inks.of, ground));
    slice.rgba.resize(4 * field.cover.size());
    parallel_for(static_cast<Index>(field.cover.size()), [&](Index k) {
        Vec3f colour;
        if (inked) colour = Vec3f(field.value[0][k], field.value[1][k], field.value[2][k]).cwiseMax(0.0f);
        else colour = colours((field.value[0][k] - range[0]) / (range[1] - range[0]));
        marks.lay_on(colour, k);
        for (int c = 0; c < 3; ++c) slice.rgba[4 * k + c] = colour[c];
        slice.rgba[4 * k + 3] = flow_cover(field.cover[k]);
    });
    return slice;
}

namespace {

using Point = Eigen::Vector2f;
using Edge = std::array<Point, 2>;

/// Edges in which the plane cuts the solid's triangles [pixels]. A corner in the plane counts as above it, so that outlines are closed.
std::vector<Edge> cut_edges(const FrameSolid& solid, const PixelPlane& plane) {
    std::vector<Vec3f> at;
    for (const Vec3f& own : solid.mesh->position) {
        const Vec3f r = (solid.rotation * own + solid.translation - plane.corner) / plane.pixel;
        at.emplace_back(r.dot(plane.right), r.dot(plane.up), r.dot(plane.normal()));
    }
    std::vector<Edge> edges;
    for (const auto& t : solid.mesh->triangle) {
        Edge edge;
        int crossings = 0;
        for (int a = 0; a < 3; ++a) {
            Vec3f p = at[t[a]], q = at[t[(a + 1) % 3]];
            if ((p.z() >= 0) == (q.z() >= 0)) continue;
            if (p.z() > q.z()) std::swap(p, q);  // bit-identical crossings from both triangles of a side
            edge[crossings++] = (p + p.z() / (p.z() - q.z()) * (q - p)).head<2>();
        }
        if (crossings == 2) edges.push_back(edge);
    }
    return edges;
}

/// Share of each pixel inside the edges by the even-odd rule. Each row has four scan lines, whose coverage of a pixel is exact.
std::vector<float> filled(const std::vector<Edge>& edges, int width, int height) {
    constexpr int lines = 4;
    std::vector<std::vector<float>> crossings(static_cast<std::size_t>(lines) * static_cast<std::size_t>(height));
    for (const Edge& e : edges) {
        const Point &low = e[0].y() < e[1].y() ? e[0] : e[1], &high = e[0].y() < e[1].y() ? e[1] : e[0];
        const int first = std::max(0, static_cast<int>(std::ceil(lines * low.y() - 0.5f)));
        for (int n = first; n < lines * height; ++n) {
            const float y = (static_cast<float>(n) + 0.5f) / lines;
            if (y >= high.y()) break;
            if (y >= low.y()) crossings[n].push_back(low.x() + (y - low.y()) / (high.y() - low.y()) * (high.x() - low.x()));
        }
    }
    std::vector<float> share(grid_count(width, height), 0.0f);
    for (int n = 0; n < lines * height; ++n) {
        std::vector<float>& at = crossings[n];
        std::sort(at.begin(), at.end());
        for (std::size_t k = 0; k + 1 < at.size(); k += 2) {
            const float a = std::clamp(at[k], 0.0f, static_cast<float>(width)), b = std::clamp(at[k + 1], 0.0f, static_cast<float>(width));
            for (int x = static_cast<int>(a); x < width && static_cast<float>(x) < b; ++x)
                share[grid_index(x, n / lines, width)] +=
                    (std::min(b, static_cast<float>(x + 1)) - std::max(a, static_cast<float>(x))) / lines;
        }
    }
    return share;
}

/// Share of each pixel that a line along the edges covers. @param line its width [pixels]
std::vector<float> stroked(const std::vector<Edge>& edges, int width, int height, float line) {
    std::vector<float> share(grid_count(width, height), 0.0f);
    const float reach = 0.5f * line + 0.5f;
    for (const Edge& e : edges) {
        const Point low = e[0].cwiseMin(e[1]), high = e[0].cwiseMax(e[1]), along = e[1] - e[0];
        const float square = std::max(along.squaredNorm(), 1e-12f);
        const int x0 = std::max(0, static_cast<int>(low.x() - reach - 1)), x1 = std::min(width - 1, static_cast<int>(high.x() + reach + 1));
        const int y0 = std::max(0, static_cast<int>(low.y() - reach - 1)),
                  y1 = std::min(height - 1, static_cast<int>(high.y() + reach + 1));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const Point p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                const float t = std::clamp((p - e[0]).dot(along) / square, 0.0f, 1.0f), away = (p - e[0] - t * along).norm();
                float& s = share[grid_index(x, y, width)];
                s = std::max(s, std::clamp(reach - away, 0.0f, 1.0f));
            }
    }
    return share;
}

}  // namespace

std::vector<SolidSection> section_solids(const Frame& frame, const PixelPlane& plane, float line) {
    std::vector<SolidSection> cuts;
    for (const FrameSolid& solid : frame.solids) {
        if (!solid.mesh) continue;
        const std::vector<Edge> edges = cut_edges(solid, plane);
        if (edges.empty()) continue;
        cuts.push_back({solid.container, filled(edges, plane.width, plane.height), stroked(edges, plane.width, plane.height, line)});
    }
    return cuts;
}

}  // namespace whorl

#include "tools/film/panel_chart.h"

#include <algorithm>
#include <cmath>

#include "render/image/canvas.h"
#include "render/look/overlay.h"

namespace whorl {
namespace {

/// sRGB, told apart by people who see no red or green, too; on black they are lifted.
Vec3f curve_colour(std::size_t k, bool dark) {
    static const std::vector<Vec3f> colours{{0.12f, 0.31f, 0.59f}, {0.80f, 0.25f, 0.12f}, {0.16f, 0.53f, 0.40f}, {0.55f, 0.35f, 0.62f}};
    const Vec3f colour = colours[k % colours.size()];
    return dark ? Vec3f(Vec3f::Constant(0.35f) + 0.65f * colour) : colour;
}

struct Box {
    double left, right, top, bottom;  // pixels
};

struct Axes {
    Box box;
    double end = 0, low = 0, high = 0;  // s; in the values' unit
    double x(double time) const { return box.left + time / end * (box.right - box.left); }
    double y(double value) const { return box.bottom - (value - low) / (high - low) * (box.bottom - box.top); }
};

Axes axes_of(const std::vector<PanelCurve>& curves, const Box& box) {
    Axes axes{box};
    for (const PanelCurve& curve : curves)
        for (std::size_t k = 0; k < curve.time.size(); ++k) {
            axes.end = std::max(axes.end, curve.time[k]);
            if (std::isfinite(curve.value[k]))
                axes.low = std::min(axes.low, curve.value[k]), axes.high = std::max(axes.high, curve.value[k]);
        }
    if (!(axes.end > 0)) axes.end = 1;
    if (!(axes.high > axes.low)) axes.high = axes.low + 1;
    return axes;
}

void draw_curve(Canvas& canvas, const Axes& axes, const PanelCurve& curve, double until, const Vec3f& colour, double width) {
    for (std::size_t k = 1; k < curve.time.size() && curve.time[k] <= until; ++k)
        if (std::isfinite(curve.value[k - 1]) && std::isfinite(curve.value[k]))
            canvas.line(axes.x(curve.time[k - 1]), axes.y(curve.value[k - 1]), axes.x(curve.time[k]), axes.y(curve.value[k]), colour,
                        width);
}

}  // namespace

Image PanelChart::at(double time) const {
    const double text = std::max(11.0, height / 9.5), thin = std::max(1.0, text / 14);
    const Vec3f paper = Vec3f::Constant(dark ? 0.0f : 1.0f), ink = Vec3f::Constant(dark ? 0.85f : 0.15f), pale = 0.3f * ink + 0.7f * paper;
    double names = 0;
    for (const PanelCurve& one : curve) names = std::max(names, Canvas::width_of(one.label, text));
    const Axes axes = axes_of(curve, {5.5 * text, width - names - 5 * text, 2.2 * text, height - 2.4 * text});
    Canvas canvas(width, height);
    canvas.box(0, 0, width, height, paper);
    const Ticks up = ticks_of(axes.low, axes.high, 4), along = ticks_of(0, axes.end, 7);
    for (std::size_t k = 0; k < up.place.size(); ++k) {
        canvas.line(axes.box.left, axes.y(up.place[k]), axes.box.right, axes.y(up.place[k]), pale, thin);
        canvas.words(axes.box.left - 0.6 * text, axes.y(up.place[k]) + 0.35 * text, up.label[k], ink, text, 1);
    }
    for (std::size_t k = 0; k < along.place.size(); ++k)
        canvas.words(axes.x(along.place[k]), axes.box.bottom + 1.4 * text, along.label[k] + (k + 1 == along.place.size() ? " s" : ""), ink,
                     text, 0);
    canvas.words(axes.box.left, 1.4 * text, title + (up.power != 0 ? " [10^" + std::to_string(up.power) + "]" : ""), ink, text);
    for (std::size_t k = 0; k < curve.size(); ++k) {
        const Vec3f colour = curve_colour(k, dark), faint = 0.3f * colour + 0.7f * paper;
        draw_curve(canvas, axes, curve[k], 1e300, faint, 1.5 * thin);
        draw_curve(canvas, axes, curve[k], time + 1e-9, colour, 2.5 * thin);
        const double line = axes.box.top + (static_cast<double>(k) + 0.5) * 1.6 * text, x = axes.box.right + 1.2 * text;
        canvas.line(x, line, x + 1.4 * text, line, colour, 2.5 * thin);
        canvas.words(x + 2 * text, line + 0.35 * text, curve[k].label, ink, text);
        const auto now = std::upper_bound(curve[k].time.begin(), curve[k].time.end(), time + 1e-9) - curve[k].time.begin();
        if (now > 0 && std::isfinite(curve[k].value[now - 1]))
            canvas.disc(axes.x(curve[k].time[now - 1]), axes.y(curve[k].value[now - 1]), 4 * thin, colour);
    }
    return canvas.image();
}

}  // namespace whorl

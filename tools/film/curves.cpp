#include "tools/film/curves.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/look/overlay.h"

namespace whorl {
namespace {

/// Colour k of the palette [sRGB], distinguishable with red-green colour blindness. @param dark brighter, for a black background
Vec3f curve_colour(std::size_t k, bool dark) {
    static const std::vector<Vec3f> colours{{0.12f, 0.31f, 0.59f}, {0.80f, 0.25f, 0.12f}, {0.16f, 0.53f, 0.40f},
                                            {0.55f, 0.35f, 0.62f}, {0.45f, 0.35f, 0.15f}, {0.35f, 0.40f, 0.45f}};
    const Vec3f colour = colours[k % colours.size()];
    return dark ? Vec3f(Vec3f::Constant(0.35f) + 0.65f * colour) : colour;
}

struct CurveAxes {
    struct Box {
        double left, right, top, bottom;
    } box;                                                ///< pixels
    double low_x = 0, high_x = 0, low_y = 0, high_y = 0;  ///< values at the sides of the box
    double x(double v) const { return box.left + (v - low_x) / (high_x - low_x) * (box.right - box.left); }
    double y(double v) const { return box.bottom - (v - low_y) / (high_y - low_y) * (box.bottom - box.top); }
    /// Extends the ranges to the finite points of the curve.
    void hold(const Curve& curve) {
        for (std::size_t k = 0; k < curve.x.size(); ++k) {
            if (!std::isfinite(curve.y[k])) continue;
            low_x = std::min(low_x, curve.x[k]), high_x = std::max(high_x, curve.x[k]);
            low_y = std::min(low_y, curve.y[k]), high_y = std::max(high_y, curve.y[k]);
        }
    }
    /// Makes every range non-empty, so that x() and y() are finite.
    void finish() {
        if (!(low_x <= high_x)) low_x = 0, high_x = 1;
        if (!(low_y <= high_y)) low_y = 0, high_y = 1;
        if (low_x == high_x) high_x = low_x + 1;
        if (low_y == high_y) high_y = low_y + std::max(1e-300, std::abs(low_y) > 0 ? std::abs(low_y) : 1);
    }
};

/// Draws horizontal grid lines with their numbers, and the numbers below the x axis. @param text size of the font [pixels]
void draw_ticks(Canvas& canvas, const CurveAxes& axes, const Ticks& up, const Ticks& along, double text, const Vec3f& ink,
                const Vec3f& pale) {
    for (std::size_t k = 0; k < up.place.size(); ++k) {
        canvas.line(axes.box.left, axes.y(up.place[k]), axes.box.right, axes.y(up.place[k]), pale, std::max(1.0, text / 14));
        canvas.words(axes.box.left - 0.6 * text, axes.y(up.place[k]) + 0.35 * text, up.label[k], ink, text, 1);
    }
    for (std::size_t k = 0; k < along.place.size(); ++k)
        canvas.words(axes.x(along.place[k]), axes.box.bottom + 1.4 * text, along.label[k], ink, text, 0);
}

/// Draws the curve up to x = `until`. Skips points within half a pixel of the previous one.
void draw_curve(Canvas& canvas, const CurveAxes& axes, const Curve& curve, double until, const Vec3f& colour, double width) {
    std::vector<std::array<double, 2>> path;
    const auto end_path = [&] {
        if (curve.style == Curve::Style::dots)
            for (const auto& p : path) canvas.disc(p[0], p[1], 1.5 * width, colour);
        else canvas.path(path, colour, width, curve.style == Curve::Style::dashed);
        path.clear();
    };
    for (std::size_t k = 0; k < curve.x.size() && curve.x[k] <= until; ++k) {
        const std::array<double, 2> p{axes.x(curve.x[k]), axes.y(curve.y[k])};
        if (!std::isfinite(p[1])) end_path();
        else if (path.empty() || std::hypot(p[0] - path.back()[0], p[1] - path.back()[1]) > 0.5) path.push_back(p);
    }
    end_path();
}

}  // namespace

Canvas draw_plots(const std::string& title, const std::vector<CurvePlot>& plots) {
    constexpr double text = 13, wide = 560, high = 340, head = 40, infinite = std::numeric_limits<double>::infinity();
    const Vec3f ink(0.13f, 0.13f, 0.16f), pale(0.86f, 0.86f, 0.88f);
    const std::size_t columns = plots.size() > 1 ? 2 : 1, rows = std::max<std::size_t>(1, (plots.size() + columns - 1) / columns);
    Canvas canvas(static_cast<int>(wide * static_cast<double>(columns)), static_cast<int>(head + high * static_cast<double>(rows)));
    canvas.words(20, 27, title, ink, 17);
    for (std::size_t n = 0; n < plots.size(); ++n) {
        const CurvePlot& plot = plots[n];
        const double x0 = wide * static_cast<double>(n % columns), y0 = head + high * static_cast<double>(n / columns);
        CurveAxes axes{{x0 + 76, x0 + wide - 24, y0 + 52, y0 + high - 56}, infinite, -infinite, infinite, -infinite};
        for (const Curve& curve : plot.curves) axes.hold(curve);
        if (axes.low_y > 0 && axes.low_y < 0.5 * axes.high_y) axes.low_y = 0;
        if (axes.high_y < 0 && axes.high_y > 0.5 * axes.low_y) axes.high_y = 0;
        const bool any = axes.low_y <= axes.high_y;
        axes.finish();
        const Ticks up = ticks_of(axes.low_y, axes.high_y, 6), along = ticks_of(axes.low_x, axes.high_x, 6);
        draw_ticks(canvas, axes, up, along, text, ink, pale);
        const CurveAxes::Box& box = axes.box;
        canvas.line(box.left, box.bottom, box.right, box.bottom, ink), canvas.line(box.left, box.top, box.left, box.bottom, ink);
        canvas.words((box.left + box.right) / 2, box.bottom + 38, axis_title(plot.x_name, plot.x_unit, along.power), ink, text, 0);
        canvas.words(x0 + 20, y0 + 16, axis_title(plot.y_name, plot.y_unit, up.power), ink, text);
        if (!any) canvas.words((box.left + box.right) / 2, (box.top + box.bottom) / 2, "nothing measured", ink, text, 0);
        double legend = box.left;
        for (const Curve& curve : plot.curves) {
            const Vec3f colour = curve_colour(curve.colour, false);
            draw_curve(canvas, axes, curve, infinite, colour, 1.8);
            const double y = y0 + 36;
            if (curve.style == Curve::Style::dots) canvas.disc(legend + 11, y - 4, 2.7, colour);
            else canvas.path({{legend, y - 4}, {legend + 22, y - 4}}, colour, 1.8, curve.style == Curve::Style::dashed);
            canvas.words(legend + 28, y, curve.label, ink, text - 1);
            legend += 44 + Canvas::width_of(curve.label, text - 1);
        }
    }
    return canvas;
}

Image PanelChart::at(double time) const {
    const double thin = std::max(1.0, text / 14);
    const Vec3f paper = Vec3f::Constant(dark ? 0.0f : 1.0f), ink = Vec3f::Constant(dark ? 0.85f : 0.15f), pale = 0.3f * ink + 0.7f * paper;
    double names = 0;
    CurveAxes axes{};  // the ranges include 0
    for (const Curve& one : curve) {
        names = std::max(names, Canvas::width_of(one.label, text));
        axes.hold(one);
        if (!one.x.empty()) axes.high_x = std::max(axes.high_x, one.x.back());
    }
    axes.box = {5.5 * text, width - names - 5 * text, 2.2 * text, height - 2.4 * text};
    axes.finish();
    Canvas canvas(width, height);
    canvas.box(0, 0, width, height, paper);
    const Ticks up = ticks_of(axes.low_y, axes.high_y, 4);
    Ticks along = ticks_of(0, axes.high_x, 7);
    if (!along.label.empty()) along.label.back() += " s";
    draw_ticks(canvas, axes, up, along, text, ink, pale);
    canvas.words(axes.box.left, 1.4 * text, axis_title(title, "", up.power), ink, text);
    for (std::size_t k = 0; k < curve.size(); ++k) {
        const Vec3f colour = curve_colour(k, dark), faint = 0.3f * colour + 0.7f * paper;
        draw_curve(canvas, axes, curve[k], 1e300, faint, 1.5 * thin);
        draw_curve(canvas, axes, curve[k], time + 1e-9, colour, 2.5 * thin);
        const double line = axes.box.top + (static_cast<double>(k) + 0.5) * 1.6 * text, x = axes.box.right + 1.2 * text;
        canvas.line(x, line, x + 1.4 * text, line, colour, 2.5 * thin);
        canvas.words(x + 2 * text, line + 0.35 * text, curve[k].label, ink, text);
        const auto now = std::upper_bound(curve[k].x.begin(), curve[k].x.end(), time + 1e-9) - curve[k].x.begin();
        if (now > 0 && std::isfinite(curve[k].y[now - 1]))
            canvas.disc(axes.x(curve[k].x[now - 1]), axes.y(curve[k].y[now - 1]), 4 * thin, colour);
    }
    return canvas.image();
}

}  // namespace whorl

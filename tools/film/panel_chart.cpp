#include "tools/film/panel_chart.h"

#include <algorithm>
#include <cmath>

namespace whorl {

Image PanelChart::at(double time) const {
    const double text = std::max(11.0, height / 9.5), thin = std::max(1.0, text / 14);
    const Vec3f paper = Vec3f::Constant(dark ? 0.0f : 1.0f), ink = Vec3f::Constant(dark ? 0.85f : 0.15f), pale = 0.3f * ink + 0.7f * paper;
    double names = 0;
    CurveAxes axes{};  // from 0
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

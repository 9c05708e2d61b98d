#pragma once
/// Curves on axes: under a film of panels, and as plots of the tables of probes.
#include <string>
#include <vector>

#include "render/image/canvas.h"
#include "render/image/image.h"
#include "render/look/overlay.h"

namespace whorl {

struct Curve {
    enum class Style { line, dashed, dots };
    std::string label;
    std::vector<double> x, y;  ///< in the columns' units, y NaN where it is not known
    Style style = Style::line;
    std::size_t colour = 0;  ///< its number among those that curve_colour() has
};

/// sRGB, distinguishable for readers who see no red or green, too. @param dark on black they are lifted
Vec3f curve_colour(std::size_t k, bool dark);

struct CurveAxes {
    struct Box {
        double left, right, top, bottom;
    } box;                                                ///< pixels
    double low_x = 0, high_x = 0, low_y = 0, high_y = 0;  ///< values at its sides
    double x(double v) const { return box.left + (v - low_x) / (high_x - low_x) * (box.right - box.left); }
    double y(double v) const { return box.bottom - (v - low_y) / (high_y - low_y) * (box.bottom - box.top); }
    /// The ranges grow by the curve's.
    void hold(const Curve& curve);
    /// No range is empty.
    void finish();
};

/// Lines across the axes with their numbers, and the numbers below. @param text size of the font [pixels]
void draw_ticks(Canvas& canvas, const CurveAxes& axes, const Ticks& up, const Ticks& along, double text, const Vec3f& ink,
                const Vec3f& pale);
/// The part of the curve up to x = `until`; of points within half a pixel one.
void draw_curve(Canvas& canvas, const CurveAxes& axes, const Curve& curve, double until, const Vec3f& colour, double width);

struct CurvePlot {
    std::string x_name, x_unit, y_name, y_unit;
    std::vector<Curve> curves;
};
/// Plots side by side under a title, each with its legend, names and units on both axes.
Canvas draw_plots(const std::string& title, const std::vector<CurvePlot>& plots);

struct PanelChart {
    std::string title;          ///< of the values
    std::vector<Curve> curve;   ///< over time [s]; their whole length decides the axes
    int width = 0, height = 0;  ///< pixels
    bool dark = false;          ///< pale lines on black

    /// Curves are strong up to this time [s] and pale after it.
    Image at(double time) const;
};

}  // namespace whorl

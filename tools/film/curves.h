#pragma once
/// Curves on axes: under a film of panels, and as plots of the tables of probes.
#include <string>
#include <vector>

#include "render/image/canvas.h"
#include "render/image/image.h"

namespace whorl {

struct Curve {
    enum class Style { line, dashed, dots };
    std::string label;
    std::vector<double> x, y;  ///< in the columns' units, y NaN where it is not known
    Style style = Style::line;
    std::size_t colour = 0;  ///< its number in the plot
};

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

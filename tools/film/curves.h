#pragma once
/// Curves on axes: plots of probe tables, and the chart below a video of panels.
#include <string>
#include <vector>

#include "render/image/canvas.h"
#include "render/image/image.h"

namespace whorl {

struct Curve {
    enum class Style { line, dashed, dots };
    std::string label;
    std::vector<double> x, y;  ///< in the columns' units; y is NaN if it is unknown
    Style style = Style::line;
    std::size_t colour = 0;  ///< index of its colour
};

struct CurvePlot {
    std::string x_name, x_unit, y_name, y_unit;
    std::vector<Curve> curves;
};
/// Draws the plots in up to two columns under a title, each with a legend and with names and units on both axes.
Canvas draw_plots(const std::string& title, const std::vector<CurvePlot>& plots);

struct PanelChart {
    std::string title;          ///< name of the plotted quantity
    std::vector<Curve> curve;   ///< over time [s]; the axes cover all points
    int width = 0, height = 0;  ///< pixels
    double text = 14;           ///< size of the font [pixels]
    bool dark = false;          ///< pale lines on black

    /// Image at this time [s]: curves are strong up to it and pale after it.
    Image at(double time) const;
};

}  // namespace whorl

#pragma once
/// The two plots that studies draw: a Pareto front and a stability map.
#include <string>
#include <vector>

#include "render/image/canvas.h"

namespace whorl {

struct PlotPoint {
    double x = 0, y = 0;
    double x_low = 0, x_high = 0;  ///< error bar
    std::string label;
    bool on_front = false;
};

/// Points on logarithmic axes. A line joins the points of the front, which have labels.
Canvas draw_front(const std::vector<PlotPoint>& points, const std::string& title, const std::string& x_name, const std::string& y_name);

struct MapCell {
    std::string state;  ///< determines the colour
    std::string note;   ///< text in the cell
};
/// Curve of a predicted limit: for each value of the first knob, the position on the second knob's axis in cells (0: its first value).
struct MapLimit {
    std::string name;
    std::vector<double> place;  ///< NaN: outside the map
};
/// One of several maps with the same axes.
struct StabilityPanel {
    std::string title;
    std::vector<MapCell> cells;  ///< x varies fastest
    std::vector<MapLimit> limits;
};
/// Maps as tables of cells: the first knob's values along x, the second's upwards.
Canvas draw_maps(const std::vector<StabilityPanel>& panels, const std::vector<std::string>& x_values,
                 const std::vector<std::string>& y_values, const std::string& title, const std::string& x_name, const std::string& y_name);

}  // namespace whorl

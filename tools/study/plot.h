#pragma once
/// The two pictures that studies draw.
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

/// Cost against error on logarithmic axes, the front joined by a line, its points labelled.
Canvas draw_front(const std::vector<PlotPoint>& points, const std::string& title, const std::string& x_name, const std::string& y_name);

struct MapCell {
    std::string state;  ///< what colours it
    std::string note;   ///< written into it
};
/// Curve of a predicted limit: position on the second knob's axis (0: its first value) for each value of the first.
struct MapLimit {
    std::string name;
    std::vector<double> place;  ///< NaN: outside the map
};
/// One map of several with the same axes.
struct StabilityPanel {
    std::string title;
    std::vector<MapCell> cells;  ///< along x first
    std::vector<MapLimit> limits;
};
/// Tables of cells: the first knob's values along x, the second's upwards.
Canvas draw_maps(const std::vector<StabilityPanel>& panels, const std::vector<std::string>& x_values,
                 const std::vector<std::string>& y_values, const std::string& title, const std::string& x_name, const std::string& y_name);

}  // namespace whorl

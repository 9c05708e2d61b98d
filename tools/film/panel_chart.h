#pragma once
/// Curves under a film of panels: a column of a probe over time, one curve a panel.
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "render/image/image.h"

namespace whorl {

struct PanelCurve {
    std::string label;
    std::vector<double> time, value;  ///< s; in the column's unit, NaN where it is not known
};

struct PanelChart {
    std::string title;              ///< of the values
    std::vector<PanelCurve> curve;  ///< their whole length decides the axes
    int width = 0, height = 0;      ///< pixels
    bool dark = false;              ///< pale lines on black

    /// Curves are strong up to this time [s] and pale after it.
    Image at(double time) const;
};

}  // namespace whorl

#pragma once
/// Curves under a film of panels: a column of a probe over time, one curve a panel.
#include <string>
#include <vector>

#include "render/image/image.h"
#include "tools/film/curves.h"

namespace whorl {

struct PanelChart {
    std::string title;          ///< of the values
    std::vector<Curve> curve;   ///< over time [s]; their whole length decides the axes
    int width = 0, height = 0;  ///< pixels
    bool dark = false;          ///< pale lines on black

    /// Curves are strong up to this time [s] and pale after it.
    Image at(double time) const;
};

}  // namespace whorl

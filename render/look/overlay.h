#pragma once
/// What is written on a picture: a legend of the colour map, and the time.
#include <array>
#include <string>
#include <vector>

#include "render/image/image.h"
#include "render/look/look_options.h"

namespace whorl {

/// "speed [m/s]": the field with its unit; on a diverging map a vector's name is that of its component, "spin z [1/s]".
std::string field_title(const LookOptions& look);

/// Numbers for a scale from low to high.
struct Ticks {
    std::vector<double> place;       ///< values, rising, in whole multiples of a step of 1, 2 or 5 times a power of ten
    std::vector<std::string> label;  ///< value / 10^power, all with the same number of decimals
    int power = 0;                   ///< 0 where numbers are easy to read without
};
/// At most `most` of them.
Ticks ticks_of(double low, double high, int most);

/// The colour map as an upright bar at the right edge, with numbers, the field's name and its unit. Values beyond the range have the
/// colours of the ends: arrows say so.
void draw_legend(Image& image, const LookOptions& look, const std::array<float, 2>& range);
/// A few words at the upper left: what a panel shows.
void draw_label(Image& image, const LookOptions& look, const std::string& text);
/// "t = 1.250 s" at the lower left.
void draw_time(Image& image, const LookOptions& look, double time);

}  // namespace whorl

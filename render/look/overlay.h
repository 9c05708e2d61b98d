#pragma once
/// Text next to a flow: a legend of the colour map, the time, a panel's title.
#include <array>
#include <string>
#include <vector>

#include "render/image/image.h"
#include "render/look/look_options.h"

namespace whorl {

struct PictureBox {
    int x = 0, y = 0, width = 0, height = 0;  ///< pixels from the upper left
};

struct Layout {
    PictureBox flow;    ///< the largest that has the flow's sides and leaves room for the words
    PictureBox margin;  ///< next to it, or below it if the flow is wider than the image; empty without text
    bool below = false;
    float text = 0;  ///< height of a capital letter [pixels]
};

/// @param aspect of the flow, width over height @param range of the legend
Layout layout_of(int width, int height, float aspect, const LookOptions& look, const std::array<float, 2>& range);
/// A picture has a legend if it shows a field by a colour map.
bool has_legend(const LookOptions& look);

/// "height [10^-3 m]": a name with its unit, neither of which needs to be there. @param power of ten that its numbers are given in
std::string axis_title(const std::string& name, const std::string& unit, int power = 0);
/// "speed [m/s]": the field with its unit; on a diverging map a vector's name is that of its component, "spin z [1/s]".
std::string field_title(const LookOptions& look, int power = 0);

/// Numbers for a scale from low to high.
struct Ticks {
    std::vector<double> place;       ///< values, rising, in whole multiples of a step of 1, 2 or 5 times a power of ten
    std::vector<std::string> label;  ///< value / 10^power, all with the same number of decimals
    int power = 0;                   ///< 0 where numbers are easy to read without
};
/// At most `most` of them.
Ticks ticks_of(double low, double high, int most);

/// The look's title, the time and the legend, those that it asks for, into the layout's margin. The legend is the colour map as a bar with
/// numbers, the field's name and its unit; values beyond the range have the colours of the ends: arrows say so.
void draw_words(Image& image, const Layout& layout, const LookOptions& look, const std::array<float, 2>& range, double time);
/// The title and the time alone, at the upper and the lower left of a picture without margin.
void draw_words_over(Image& image, const LookOptions& look, double time);

}  // namespace whorl

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
    PictureBox flow;     ///< largest box of the flow's aspect that leaves room for the text
    PictureBox margin;   ///< box of the text, beside the flow or below it, whichever leaves the flow larger; empty without text
    bool below = false;  ///< the margin is below the flow
    float text = 0;      ///< height of a capital letter [pixels]
};

/// Boxes of the flow and its text in an image.
/// @param width, height of the image [pixels] @param aspect of the flow, width over height @param range of the legend
Layout layout_of(int width, int height, float aspect, const LookOptions& look, const std::array<float, 2>& range);
/// Whether the look draws a legend: it asks for one and shows a field by a colour map (inks have none).
bool has_legend(const LookOptions& look);

/// A name with its unit, "height [10^-3 m]"; both may be empty. @param power of ten by which the numbers on the axis are divided
std::string axis_title(const std::string& name, const std::string& unit, int power = 0);
/// The field with its unit, "speed [m/s]". On a diverging map a vector field shows its component, "spin z [1/s]".
std::string field_title(const LookOptions& look, int power = 0);

/// Tick values of a scale and their labels.
struct Ticks {
    std::vector<double> place;       ///< rising multiples of a step of 1, 2 or 5 times a power of ten
    std::vector<std::string> label;  ///< value / 10^power, all with the same number of decimals
    int power = 0;                   ///< 0 if the numbers are readable unscaled
};
/// At most `most` ticks of a scale from low to high.
Ticks ticks_of(double low, double high, int most);

/// Draws the title, the time and the legend into the layout's margin, as far as the look requests them. The legend is the colour map as a
/// bar with numbers, the field's name and its unit. Its ends are arrows, because values beyond the range have the end colours.
void draw_words(Image& image, const Layout& layout, const LookOptions& look, const std::array<float, 2>& range, double time);
/// Draws the title at the upper left and the time at the lower left of an image without a margin.
void draw_words_over(Image& image, const LookOptions& look, double time);

}  // namespace whorl

#include "render/look/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "render/image/text.h"
#include "render/look/colour_map.h"

namespace whorl {
namespace {

/// Height of a capital letter: 14 pixels of a picture of 720.
float text_height(const Image& image) { return std::max(6.0f, static_cast<float>(std::min(image.height, image.width)) / 51); }

TextStyle style_for(const Image& image, const LookOptions& look) {
    TextStyle style;
    style.height = text_height(image);
    style.colour = Vec3f::Constant(0.1f);
    if (look.background == "dark") std::swap(style.colour, style.halo);
    return style;
}

std::string unit_of(const std::string& field) {
    static const std::map<std::string, std::string> units{{"speed", "m/s"}, {"pressure", "Pa"},   {"density", "kg/m^3"},
                                                          {"spin", "1/s"},  {"vorticity", "1/s"}, {"spin_difference", "1/s"}};
    const auto found = units.find(field);
    return found == units.end() ? "" : found->second;
}

std::string with_unit(const LookOptions& look, int power) {
    const bool vector = look.field == "spin" || look.field == "vorticity" || look.field == "spin_difference";
    std::string unit = unit_of(look.field);
    if (power != 0) unit = fmt::format("10^{}{}{}", power, unit.empty() ? "" : " ", unit);
    const std::string name = look.field == "spin_difference" ? "spin - vorticity/2" : look.field;
    return name + (vector && is_diverging(look.colour_map) ? " z" : "") + (unit.empty() ? "" : " [" + unit + "]");
}

}  // namespace

std::string field_title(const LookOptions& look) { return with_unit(look, 0); }

Ticks ticks_of(double low, double high, int most) {
    const double rough = (high - low) / std::max(1, most - 1), magnitude = std::pow(10.0, std::floor(std::log10(rough)));
    double step = 10 * magnitude;
    const auto count = [&](double s) { return std::floor(high / s + 1e-6) - std::ceil(low / s - 1e-6) + 1; };
    for (const double factor : {1.0, 2.0, 5.0})
        if (count(factor * magnitude) <= most) {
            step = factor * magnitude;
            break;
        }
    Ticks ticks;
    const double largest = std::max(std::abs(low), std::abs(high));
    if (largest >= 1e5 || largest < 1e-2) ticks.power = static_cast<int>(std::floor(std::log10(largest)));
    const double scale = std::pow(10.0, ticks.power);
    const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step / scale * (1 + 1e-9)))));
    for (double k = std::ceil(low / step - 1e-6); k <= high / step + 1e-6; ++k) {
        ticks.place.push_back(k * step);
        ticks.label.push_back(fmt::format("{:.{}f}", std::abs(k) < 0.5 ? 0.0 : k * step / scale, decimals));
    }
    return ticks;
}

void draw_legend(Image& image, const LookOptions& look, const std::array<float, 2>& range) {
    const TextStyle style = style_for(image, look);
    const Ticks ticks = ticks_of(range[0], range[1], 7);
    const std::string title = with_unit(look, ticks.power);
    float numbers = 0;
    for (const std::string& label : ticks.label) numbers = std::max(numbers, text_width(label, style.height));

    const float margin = 2 * style.height, dash = 0.6f * style.height;
    const int bar = static_cast<int>(std::lround(1.5f * style.height)), tall = image.height / 2, arrow = bar / 2;
    const float right =
        static_cast<float>(image.width) - margin - std::max(numbers, text_width(title, style.height) - static_cast<float>(bar) - 2 * dash);
    const int x = static_cast<int>(right - 2 * dash) - bar, top = (image.height - tall) / 2;
    const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(255 * c)); };
    for (int row = -arrow; row < tall + arrow; ++row) {
        const Vec3f colour = map_colour(look.colour_map, 1 - (static_cast<float>(row) + 0.5f) / static_cast<float>(tall));
        const int narrow = std::max({0, -row, row + 1 - tall}) * bar / (2 * std::max(arrow, 1));
        for (int column = narrow; column < bar - narrow; ++column)
            if (top + row >= 0 && top + row < image.height && x + column >= 0 && x + column < image.width)
                for (int c = 0; c < 3; ++c) image.pixel(x + column, top + row)[c] = byte(colour[c]);
    }
    for (std::size_t n = 0; n < ticks.place.size(); ++n) {
        const double up = (ticks.place[n] - range[0]) / (static_cast<double>(range[1]) - range[0]);
        const float y = static_cast<float>(top + tall) - static_cast<float>(up) * static_cast<float>(tall);
        const int thick = std::max(1, static_cast<int>(std::lround(style.height / 9)));
        tint_box(image, x + bar, static_cast<int>(std::lround(y - 0.5f * static_cast<float>(thick))), static_cast<int>(dash), thick,
                 style.colour, 1);
        draw_text(image, static_cast<float>(x + bar) + 2 * dash, y + 0.5f * style.height, ticks.label[n], style);
    }
    draw_text(image, static_cast<float>(x), static_cast<float>(top - arrow) - style.height, title, style);
}

void draw_label(Image& image, const LookOptions& look, const std::string& text) {
    TextStyle style = style_for(image, look);
    style.height *= 1.3f;
    draw_text(image, 2 * style.height, 2.5f * style.height, text, style);
}

void draw_time(Image& image, const LookOptions& look, double time) {
    const TextStyle style = style_for(image, look);
    draw_text(image, 2 * style.height, static_cast<float>(image.height) - 2 * style.height, fmt::format("t = {:.3f} s", time), style);
}

}  // namespace whorl

#include "render/look/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/image/text.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"

namespace whorl {
namespace {

/// Height of a capital letter [pixels]: the look's, or 14 in an image of 720 lines. It is legible in an image of 360 lines.
float text_height(int width, int height, const LookOptions& look) {
    return look.text_size > 0 ? look.text_size : std::max(9.0f, static_cast<float>(std::min(width, height)) / 51);
}

TextStyle style_for(const Image& image, const LookOptions& look) {
    TextStyle style;
    style.height = text_height(image.width, image.height, look);
    style.colour = Vec3f::Constant(0.1f);
    if (look.background == "dark") std::swap(style.colour, style.halo);
    return style;
}

}  // namespace

std::string axis_title(const std::string& name, const std::string& unit, int power) {
    const std::string scaled = power == 0 ? unit : fmt::format("10^{}{}{}", power, unit.empty() ? "" : " ", unit);
    return scaled.empty() ? name : name + " [" + scaled + "]";
}

std::string field_title(const LookOptions& look, int power) {
    const bool vector = look.field == "spin" || look.field == "vorticity" || look.field == "spin_difference";
    const std::string name = look.field == "spin_difference" ? "spin - vorticity/2" : look.field == "q_criterion" ? "Q" : look.field;
    return axis_title(name + (vector && is_diverging(look.colour_map) ? " z" : ""), unit_of(look.field), power);
}

Ticks ticks_of(double low, double high, int most) {
    if (low > high) std::swap(low, high);
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

namespace {

struct Bar {
    bool upright;
    float x, y, length, thick;  ///< pixels; x, y: the upper left corner
};

/// Draws the colour map along the bar, with an arrow at each end.
void draw_bar(Image& image, const std::string& map, const Bar& bar) {
    const float arrow = 0.5f * bar.thick;
    const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(255 * c)); };
    const int across = static_cast<int>(std::lround(bar.thick)), from = -static_cast<int>(arrow), to = static_cast<int>(bar.length + arrow);
    for (int n = from; n < to; ++n) {
        const float t = (static_cast<float>(n) + 0.5f) / bar.length;
        const Vec3f colour = map_colour(map, bar.upright ? 1 - t : t);
        const int narrow = std::max({0, -n, n + 1 - static_cast<int>(bar.length)});
        for (int m = narrow; m < across - narrow; ++m) {
            const int x = static_cast<int>(bar.x) + (bar.upright ? m : n), y = static_cast<int>(bar.y) + (bar.upright ? n : m);
            if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = byte(colour[c]);
            if (!image.alpha.empty()) image.alpha[grid_index(x, y, image.width)] = 255;
        }
    }
}

void draw_ticks(Image& image, const Ticks& ticks, const std::array<float, 2>& range, const Bar& bar, const TextStyle& style) {
    const int thin = std::max(1, static_cast<int>(std::lround(style.height / 9))),
              dash = static_cast<int>(std::lround(0.4f * style.height));
    for (std::size_t n = 0; n < ticks.place.size(); ++n) {
        const float t = static_cast<float>((ticks.place[n] - range[0]) / (static_cast<double>(range[1]) - range[0]));
        const float end = bar.thick + static_cast<float>(dash);
        if (bar.upright) {
            const float y = bar.y + (1 - t) * bar.length;
            tint_box(image, static_cast<int>(bar.x + bar.thick), static_cast<int>(y), dash, thin, style.colour, 1);
            draw_text(image, bar.x + end + 0.4f * style.height, y + 0.5f * style.height, ticks.label[n], style);
        } else {
            const float x = bar.x + t * bar.length;
            tint_box(image, static_cast<int>(x), static_cast<int>(bar.y + bar.thick), thin, dash, style.colour, 1);
            draw_text(image, x - 0.5f * text_width(ticks.label[n], style.height), bar.y + end + 1.4f * style.height, ticks.label[n], style);
        }
    }
}

/// Draws title, legend and time, one below the other.
void draw_column(Image& image, const PictureBox& box, const LookOptions& look, const std::array<float, 2>& range, const std::string& time,
                 const TextStyle& style) {
    const float h = style.height, x = static_cast<float>(box.x) + h, top = static_cast<float>(box.y);
    const float bottom = top + static_cast<float>(box.height);
    if (!look.title.empty()) draw_text(image, x, top + h, look.title, style);
    if (!time.empty()) draw_text(image, x, bottom, time, style);
    if (!has_legend(look)) return;
    const float above = top + (look.title.empty() ? 0 : 2.2f * h), below = bottom - (time.empty() ? 0 : 2.2f * h);
    const float length = std::min(0.62f * (below - above), 24 * h), middle = 0.5f * (above + below) + h;
    const Bar bar{true, x, middle - 0.5f * length, length, 1.3f * h};
    const Ticks ticks = ticks_of(range[0], range[1], std::clamp(static_cast<int>(length / (2.2f * h)), 2, 7));
    draw_bar(image, look.colour_map, bar);
    draw_ticks(image, ticks, range, bar, style);
    draw_text(image, x, bar.y - 1.8f * h, field_title(look, ticks.power), style);
}

/// Draws the title and the time at the left, the legend at the right.
void draw_strip(Image& image, const PictureBox& box, const LookOptions& look, const std::array<float, 2>& range, const std::string& time,
                const TextStyle& style) {
    const float h = style.height, left = static_cast<float>(box.x), first = static_cast<float>(box.y) + 1.8f * h;
    const float right = left + static_cast<float>(box.width);
    const bool two_lines = has_legend(look);
    if (!look.title.empty()) draw_text(image, left, first, look.title, style);
    if (!time.empty()) {
        if (two_lines) draw_text(image, left, first + 1.8f * h, time, style);
        else draw_text(image, right - text_width("t = 00.000 s", h), first, time, style);
    }
    if (!two_lines) return;
    float taken = 5 * h + text_width(field_title(look, ticks_of(range[0], range[1], 7).power), h);
    if (!look.title.empty()) taken += text_width(look.title, h);
    const float wide = static_cast<float>(box.width),
                length = std::clamp(wide - taken, std::min(8 * h, 0.45f * wide), std::min(0.45f * wide, 32 * h));
    const Bar bar{false, right - length - 1.5f * h, first - h, length, 1.2f * h};
    const Ticks ticks = ticks_of(range[0], range[1], std::clamp(static_cast<int>(length / (4 * h)), 2, 7));
    draw_bar(image, look.colour_map, bar);
    draw_ticks(image, ticks, range, bar, style);
    const std::string title = field_title(look, ticks.power);
    draw_text(image, bar.x - 1.5f * h - text_width(title, h), first, title, style);
}

std::string time_text(const LookOptions& look, double time) { return look.time_stamp ? fmt::format("t = {:.3f} s", time) : ""; }

}  // namespace

void draw_words(Image& image, const Layout& layout, const LookOptions& look, const std::array<float, 2>& range, double time) {
    TextStyle style = style_for(image, look);
    style.height = layout.text;
    style.halo_strength = 0;
    (layout.below ? draw_strip : draw_column)(image, layout.margin, look, range, time_text(look, time), style);
}

void draw_words_over(Image& image, const LookOptions& look, double time) {
    const TextStyle style = style_for(image, look);
    const float h = style.height;
    if (!look.title.empty()) draw_text(image, 2 * h, 3 * h, look.title, style);
    if (look.time_stamp) draw_text(image, 2 * h, static_cast<float>(image.height) - 2 * h, time_text(look, time), style);
}

namespace {

/// The largest box of this aspect, centred in `room`.
PictureBox fitted(const PictureBox& room, float aspect) {
    PictureBox box = room;
    const float wide = static_cast<float>(room.width), tall = static_cast<float>(room.height);
    if (wide > aspect * tall) box.width = std::max(1, static_cast<int>(std::lround(aspect * tall)));
    else box.height = std::max(1, static_cast<int>(std::lround(wide / aspect)));
    box.x += (room.width - box.width) / 2, box.y += (room.height - box.height) / 2;
    return box;
}

float column_width(const LookOptions& look, const std::array<float, 2>& range, float text) {
    float wide = 0;
    if (!look.title.empty()) wide = text_width(look.title, text);
    if (look.time_stamp) wide = std::max(wide, text_width("t = 00.000 s", text));
    if (has_legend(look)) {
        const Ticks ticks = ticks_of(range[0], range[1], 7);
        wide = std::max(wide, text_width(field_title(look, ticks.power), text));
        for (const std::string& label : ticks.label) wide = std::max(wide, 3 * text + text_width(label, text));
    }
    return wide > 0 ? wide + 2 * text : 0;
}

}  // namespace

bool has_legend(const LookOptions& look) { return look.legend && shows_field(look) && look.field != "ink"; }

Layout layout_of(int width, int height, float aspect, const LookOptions& look, const std::array<float, 2>& range) {
    Layout layout;
    layout.text = text_height(width, height, look);
    const bool words = !look.title.empty() || look.time_stamp || has_legend(look);
    if (!words) {
        layout.flow = fitted({0, 0, width, height}, aspect);
        return layout;
    }
    const int edge = static_cast<int>(std::lround(0.8f * layout.text));
    const int strip = static_cast<int>(std::lround((has_legend(look) ? 4.6f : 2.2f) * layout.text));
    const int column = std::min(width / 2, static_cast<int>(std::lround(column_width(look, range, layout.text))));
    const PictureBox above = fitted({edge, edge, width - 2 * edge, height - edge - strip}, aspect);
    const PictureBox left = fitted({edge, edge, width - edge - column, height - 2 * edge}, aspect);
    layout.below = above.width >= left.width;
    layout.flow = layout.below ? above : left;
    // The margin touches the flow, so that both are together in the middle of the image.
    if (layout.below) layout.margin = {layout.flow.x, layout.flow.y + layout.flow.height, layout.flow.width, strip};
    else layout.margin = {layout.flow.x + layout.flow.width, layout.flow.y, column, layout.flow.height};
    return layout;
}

}  // namespace whorl

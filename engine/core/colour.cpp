#include "engine/core/colour.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace whorl {

bool read_colour(const std::string& text, Vec3f& colour) {
    if (text.size() != 7 || text[0] != '#' || text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos) return false;
    for (int c = 0; c < 3; ++c)
        colour[c] = static_cast<float>(std::stoi(text.substr(1 + 2 * static_cast<std::size_t>(c), 2), nullptr, 16)) / 255;
    return true;
}

float linear_of(float srgb) { return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f); }

Vec3f linear_of(const Vec3f& srgb) {
    return srgb.unaryExpr([](float c) { return linear_of(c); });
}

std::string hex_of(const Vec3f& linear) {
    std::string text = "#";
    for (const float light : linear) {
        const float srgb = light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
        text += fmt::format("{:02x}", std::clamp(static_cast<int>(std::lround(255 * srgb)), 0, 255));
    }
    return text;
}

Vec3f colour_of(const Value& text) {
    Vec3f colour;
    if (!read_colour(*text.as<std::string>(), colour))
        throw KeyFault(text.place, text.toml() + " is not a colour; write red, green and blue as in \"#1e50a0\"");
    return colour;
}

Value KeyCodec<Colour>::from_text(const Value& text) {
    const Vec3f linear = linear_of(colour_of(text));
    Value list = write({linear.x(), linear.y(), linear.z()});
    list.place = text.place;
    return list;
}

}  // namespace whorl

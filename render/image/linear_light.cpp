#include "render/image/linear_light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace whorl {
namespace {

// IEC 61966-2-1
float decoded(float s) { return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f); }
float encoded(float l) { return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f; }

}  // namespace

float linear_light(std::uint8_t srgb) {
    static const auto table = [] {
        std::array<float, 256> light{};
        for (int i = 0; i < 256; ++i) light[i] = decoded(static_cast<float>(i) / 255);
        return light;
    }();
    return table[srgb];
}

std::uint8_t srgb_byte(float light) { return static_cast<std::uint8_t>(std::lround(255 * encoded(std::clamp(light, 0.0f, 1.0f)))); }

}  // namespace whorl

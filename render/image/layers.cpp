#include "render/image/layers.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/core/types.h"

namespace whorl {
namespace {

// The same as in render/shaders/compose.frag, which draws opaque pictures without this detour.

// Khronos PBR Neutral tone mapper (Khronos Group, 2024).
Vec3f tone(Vec3f colour) {
    constexpr float start = 0.8f - 0.04f, desaturation = 0.15f, d = 1 - start;
    const float x = colour.minCoeff();
    colour.array() -= x < 0.08f ? x - 6.25f * x * x : 0.04f;
    const float peak = colour.maxCoeff();
    if (peak < start) return colour;
    const float compressed = 1 - d * d / (peak + d - start), g = 1 - 1 / (desaturation * (peak - compressed) + 1);
    return (1 - g) * colour * (compressed / peak) + Vec3f::Constant(g * compressed);
}

float srgb(float light) {
    light = std::clamp(light, 0.0f, 1.0f);
    return light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
}

float fraction(float x) { return x - std::floor(x); }
/// @param x, y middle of the pixel, from the lower left
float dither(float x, float y) { return fraction(52.9829189f * fraction(0.06711056f * x + 0.00583715f * y)) - 0.5f; }

std::uint8_t byte(float value) { return static_cast<std::uint8_t>(std::lround(std::clamp(255 * value, 0.0f, 255.0f))); }

/// How much of a pixel of the ground the shadow takes away.
float darkening(const float* shadow) {
    const float light = 0.2126f * shadow[0] + 0.7152f * shadow[1] + 0.0722f * shadow[2];
    return light < 1 ? 1 - srgb(light) : 0.0f;
}

}  // namespace

Image shown(const PictureLayers& layers) {
    Image image = plain_image(layers.width, layers.height, 0);
    const bool transparent = !layers.shadow.empty();
    if (transparent) image.alpha.assign(grid_count(layers.width, layers.height), 0);
    parallel_blocks(layers.height, 16, [&](Index first, Index last) {
        for (Index y = first; y < last; ++y)
            for (int x = 0; x < layers.width; ++x) {
                const std::size_t i = grid_index(x, static_cast<int>(y), layers.width);
                const float* light = &layers.light[4 * i];
                const float solid = light[3];
                const float whole = transparent ? solid + (1 - solid) * darkening(&layers.shadow[3 * i]) : 1;
                if (transparent) image.alpha[i] = byte(whole);
                if (solid <= 0) continue;
                const Vec3f colour = tone(Vec3f(light[0], light[1], light[2]) / solid);
                const float noise = dither(static_cast<float>(x) + 0.5f, static_cast<float>(layers.height - y) - 0.5f) / 255;
                for (int c = 0; c < 3; ++c) image.rgb[3 * i + c] = byte((srgb(colour[c]) + noise) * solid / whole);
            }
    });
    return image;
}

}  // namespace whorl

#pragma once
/// Text on images.
#include <string>

#include "engine/core/types.h"
#include "render/image/image.h"

namespace whorl {

struct TextStyle {
    float height = 14;             ///< height of a capital letter [pixels]
    Vec3f colour = Vec3f::Zero();  ///< sRGB, 0 .. 1
    Vec3f halo = Vec3f::Ones();    ///< colour around every letter, so that it can be read on any background
    float halo_strength = 0.6f;    ///< 0: none
};

/// Draws UTF-8 text, whose baseline starts at x, y [pixels from the upper left]. "^" raises the digits and signs that follow it, as an
/// exponent: "kg/m^3". Characters that the font lacks are drawn as a box.
void draw_text(Image& image, float x, float y, const std::string& text, const TextStyle& style);
/// Width of the text as drawn [pixels].
float text_width(const std::string& text, float height);

/// Mixes a rectangle of the image with a colour, in linear light. @param share fraction of the colour, 0 .. 1
void tint_box(Image& image, int x, int y, int width, int height, const Vec3f& colour, float share);

}  // namespace whorl

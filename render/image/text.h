#pragma once
/// Words on pictures.
#include <string>

#include "engine/core/types.h"
#include "render/image/image.h"

namespace whorl {

struct TextStyle {
    float height = 14;             ///< of a capital letter [pixels]
    Vec3f colour = Vec3f::Zero();  ///< sRGB, 0 .. 1
    Vec3f halo = Vec3f::Ones();    ///< round every letter, so that it can be read on anything
    float halo_strength = 0.6f;    ///< 0: none
};

/// Draws UTF-8; x, y is where the first letter's baseline begins [pixels from the upper left]. "^" lifts what follows (digits, signs) as an
/// exponent: "kg/m^3". Characters that the font does not have are drawn as a box.
void draw_text(Image& image, float x, float y, const std::string& text, const TextStyle& style);
/// Width of the text as drawn [pixels].
float text_width(const std::string& text, float height);

/// Mixes a rectangle of the picture towards a colour, in linear light. @param share of the colour, 0 .. 1
void tint_box(Image& image, int x, int y, int width, int height, const Vec3f& colour, float share);

}  // namespace whorl

#pragma once
/// Colours in scene files, and the appearance of solids.
#include <string>

#include "engine/core/keys.h"

namespace whorl {

/// Linear red, green, blue. A scene file may also write it as "#rrggbb" (sRGB).
struct Colour : Vec3f {
    using Vec3f::Vec3f;
};

/// Appearance of a solid or a nozzle in images. Negative values: those of the material.
struct Appearance {
    std::string material = "ceramic";
    Colour colour{-1, -1, -1};  ///< diffuse colour; tint of a metal's reflection; transmission of 1 cm of glass
    float roughness = -1;       ///< 0 mirror .. 1 matt
    float metallic = -1;        ///< 0 or 1
    bool show = true;
    friend bool operator==(const Appearance&, const Appearance&) = default;
};

/// "#rrggbb" -> sRGB, 0 .. 1. @return false if the text is not a colour
bool read_colour(const std::string& text, Vec3f& colour);
/// Linear light of an sRGB value (IEC 61966-2-1), both 0 to 1.
float linear_of(float srgb);
Vec3f linear_of(const Vec3f& srgb);

/// sRGB, 0 .. 1. @throws KeyFault if the text is not a colour
Vec3f colour_of(const Value& text);

template <>
struct KeyCodec<Colour> : ListCodec<Colour, float, 3> {
    static Value from_text(const Value& text);
};

}  // namespace whorl

#pragma once
/// Colours in scene files, the appearance of solids, and lights.
#include <array>
#include <filesystem>
#include <optional>
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
    Colour colour{-1, -1, -1};            ///< diffuse colour; tint of a metal's reflection; transmission of 1 cm of glass
    float roughness = -1;                 ///< 0 mirror .. 1 matt
    float metallic = -1;                  ///< 0 or 1
    std::filesystem::path texture{};      ///< picture on a solid (PNG, JPEG), whose colour it replaces; empty: none
    std::optional<float> texture_size{};  ///< width that the picture covers [m]; it repeats; empty: by texture_mesh, or once over the solid
    std::filesystem::path texture_mesh{};  ///< OBJ file of the solid, which may have texture coordinates; empty: the picture is projected
    bool show = true;
    friend bool operator==(const Appearance&, const Appearance&) = default;
};

/// A light of the scene. Together, all lights replace the lamps of the surround.
struct Light {
    static constexpr std::size_t most = 8;  ///< in a scene
    std::string kind = "soft_box";          ///< soft_box (a rectangle) | lamp (a ball) | sun (parallel light)
    Vec3f position = Vec3f::Zero();         ///< centre [m]
    std::optional<Vec3f> target;            ///< point that a soft box faces, where light has its strength [m]; empty: the domain's middle
    std::array<float, 2> size{0, 0};        ///< width and height of a soft box [m]
    float radius = 0;                       ///< of a lamp [m]
    Vec3f direction{-0.4f, -1, -0.3f};      ///< direction of a sun's light, of any length
    float angle = 0.53f;                    ///< angular diameter of a sun [degrees]
    Colour colour{1, 1, 1};
    float strength = 1;
    friend bool operator==(const Light&, const Light&) = default;
};

/// "#rrggbb" -> sRGB, 0 .. 1. @return false if the text is not a colour
bool read_colour(const std::string& text, Vec3f& colour);
/// Linear light of an sRGB value (IEC 61966-2-1), both 0 to 1.
float linear_of(float srgb);
Vec3f linear_of(const Vec3f& srgb);

/// "#rrggbb" of linear light, 0 .. 1.
std::string hex_of(const Vec3f& linear);

/// sRGB, 0 .. 1. @throws KeyFault if the text is not a colour
Vec3f colour_of(const Value& text);

template <>
struct KeyCodec<Colour> : ListCodec<Colour, float, 3> {
    static Value from_text(const Value& text);
};

}  // namespace whorl

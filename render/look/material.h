#pragma once
/// Materials of the fluid and of solids, as the shaders take them.
#include <array>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "render/look/look_options.h"

namespace whorl {

// Inks as painters mix them: light that goes through a layer of pigments is absorbed and scattered by each of them.

/// Kubelka and Munk (1931): in a layer where the pigments scatter S and absorb K of the light, per band and unit of thickness,
///   K/S = (1 - R)^2/(2 R)       of a pigment that looks R where the layer hides all behind it
///   R   = (1 - R_g (a - q))/(a - R_g + q),   a = 1 + K/S, b = sqrt(a^2 - 1), q = b coth(b S)      (Kubelka 1948)
/// of a layer of unit thickness on a ground R_g. K and S are the sums over the pigments, each times its concentration and the square
/// root of that of all; the bands are red, green and blue. Blue and yellow make green, inks that thin out let the ground through.
class Pigments {
public:
    /// @param colours up to three, "#rrggbb" (sRGB) @param ground reflectance of what lies behind, linear RGB
    Pigments(const std::vector<std::string>& colours, const Vec3f& ground);
    /// Linear RGB of inks of these concentrations, 0 .. 1.
    Vec3f operator()(const Vec3f& concentration) const;

private:
    std::array<Vec3f, 3> absorption_;  ///< K/S of each
    Vec3f ground_;
};

/// K/S of inks of these colours.
std::array<Vec3f, 3> absorption_ratios(const std::vector<std::string>& colours);

/// "#rrggbb" -> sRGB, 0 .. 1. @return false if the text is not a colour
bool read_colour(const std::string& text, Vec3f& colour);

/// Material of the fluid. Colours are linear RGB.
struct Material {
    bool refracts = true;                  ///< light passes through; else it is an opaque paint
    Vec3f absorption = Vec3f::Zero();      ///< 1/m, Beer-Lambert
    Vec3f scatter = Vec3f::Zero();         ///< colour of the light that the body itself gives back (the glow of honey)
    float haze = 0;                        ///< 1/m, how fast a ray picks that colour up
    Vec3f colour = Vec3f::Constant(0.5f);  ///< of an opaque material, diffuse
    Vec3f emission = Vec3f::Zero();        ///< emitted radiance (lava)
    float cooling = 0;                     ///< s, in which fluid that knows its age loses most of that light; 0: never
    float refraction = 1.49f;              ///< index
    float roughness = 0.05f;               ///< 0 mirror .. 1 matt
    float softness = 0;                    ///< 0 .. 1: light creeps round the edge of shadow (chocolate, clay, paint)
};

/// The preset of the look with the keys that the user gave put over it.
/// A preset's absorption is real for things up to the size of a table; in a larger scene it falls with 1/size, or honey would be black.
/// Absorption that the user gives is taken as it is.
/// @param size diagonal of the scene [m]
Material fluid_material(const LookOptions& look, float size);
/// Fraction of the surrounding light that a body of the fluid keeps from things inside it: 1 paint and honey, near 0 clear water.
/// @param size diagonal of the scene [m], of which a body is taken to be an eighth thick
float hides(const Material& material, float size);
std::vector<std::string> material_names();

/// Radiance of a body that glows, from 0 cold to 1 as hot as it comes: the hotter, the yellower. Duplicated in opaque.frag.
Vec3f glow_of(const Vec3f& emission, float heat);
/// Heat of a crust's outside and inside its cracks, at an age over the time of cooling.
float heat_of_crust(float age);

/// Textures of solids and of the ground, numbered as in textures.glsl; paper: the backdrop continues.
enum class Pattern { paper = -1, plain = 0, wood_rings = 1, planks = 2, rock = 3, slab = 4, cloth = 5 };

/// Material of a solid.
struct SolidMaterial {
    Vec3f colour = Vec3f::Constant(0.7f);  ///< diffuse, or the tint of the reflection of a metal
    float roughness = 0.3f;
    float metal = 0;  ///< 0 or 1
    Pattern pattern = Pattern::plain;
};
/// ceramic | white | metal | wood | clay | dark | rock | glass | cloth; any other name: ceramic.
SolidMaterial solid_material(const std::string& name);
std::vector<std::string> solid_material_names();
/// Material of the ground: none (paper) | plain | wood | stone | cloth; any other name: none.
SolidMaterial table_material(const std::string& name);
std::vector<std::string> table_names();

}  // namespace whorl

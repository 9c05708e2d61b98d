#pragma once
/// Materials of the fluid and of solids, as the shaders use them.
#include <array>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "render/look/look_options.h"

namespace whorl {

/// Colour of mixed inks by Kubelka and Munk (1931). Each pigment of a layer absorbs a share K and scatters a share S of the light, per unit
/// of thickness and per band (red, green, blue).
///   K/S = (1 - R)^2/(2 R)       for a pigment whose opaque layer has reflectance R
///   R   = (1 - R_g (a - q))/(a - R_g + q),   a = 1 + K/S, b = sqrt(a^2 - 1), q = b coth(b S)      (Kubelka 1948)
///                               for a layer of unit thickness on a ground of reflectance R_g
/// K and S are sums over the pigments, each weighted by its concentration times the square root of the total concentration. So blue and
/// yellow make green, and thin inks let the ground through.
class Pigments {
public:
    /// @param colours up to three, "#rrggbb" (sRGB) @param ground reflectance of the ground, linear RGB
    Pigments(const std::vector<std::string>& colours, const Vec3f& ground);
    /// Linear RGB of a mixture. @param concentration of each ink, 0 .. 1
    Vec3f operator()(const Vec3f& concentration) const;

private:
    std::array<Vec3f, 3> absorption_;  ///< K/S of each pigment
    Vec3f ground_;
};

/// K/S of up to three inks whose opaque layers have these colours ("#rrggbb", sRGB).
std::array<Vec3f, 3> absorption_ratios(const std::vector<std::string>& colours);

/// Material of the fluid. Colours are linear RGB.
struct Material {
    bool refracts = true;                  ///< true: light passes through; false: opaque
    Vec3f absorption = Vec3f::Zero();      ///< 1/m, Beer-Lambert
    Vec3f scatter = Vec3f::Zero();         ///< colour of light scattered inside the body (the glow of honey)
    float haze = 0;                        ///< 1/m, rate at which a ray gains the colour `scatter`
    Vec3f colour = Vec3f::Constant(0.5f);  ///< diffuse colour of an opaque material
    Vec3f emission = Vec3f::Zero();        ///< emitted radiance (lava)
    float cooling = 0;                     ///< s, age at which the fluid has lost most of its emission; 0: never
    float refraction = 1.49f;              ///< index of refraction
    float roughness = 0.05f;               ///< 0 mirror .. 1 matt
    float softness = 0;                    ///< 0 .. 1, how far light spreads beyond the edge of shadow (chocolate, clay, paint)
    float scattering = 0;                  ///< m, transport mean free path in an opaque material (cream, wax); 0: light does not enter it
};

/// (1 + F)/(1 - F), where F is the fraction of diffuse light that the surface reflects inwards, for an index of refraction of 1.4.
/// Duplicated in opaque.frag.
constexpr float inner_reflection = 3.2f;

/// Rate k [1/m] at which diffuse light fades inside an opaque material, per band: k = sqrt(3 (1 - a))/l, where l is the transport mean free
/// path and a the albedo for which a thick layer has the material's colour R (Jensen and Buhler 2002):
///   R = a/2 (1 + exp(-4/3 A sqrt(3 (1 - a)))) exp(-sqrt(3 (1 - a))),   A = inner_reflection
Vec3f diffuse_attenuation(const Material& material);
/// Mean distance [m], per band, between the places where diffuse light enters and leaves an opaque material of colour R (Christensen and
/// Burley 2015): 2.5 l/(1.9 - R + 3.5 (R - 0.8)^2).
Vec3f sideways_reach(const Material& material);

/// The look's preset, with the keys that the scene sets.
/// A preset's absorption is realistic in scenes up to the size of a table (0.4 m). In a larger scene it decreases as 1/size, or honey would
/// be black. Absorption that the scene sets is used unchanged.
/// @param size diagonal of the scene [m]
Material fluid_material(const LookOptions& look, float size);
/// Fraction of the surrounding light that a body of fluid blocks from objects inside it: 1 for paint, at most 0.75 for honey,
/// near 0 for clear water.
/// @param size diagonal of the scene [m]; the body is assumed to be an eighth of it thick
float hides(const Material& material, float size);
std::vector<std::string> material_names();

/// Radiance of a glowing body, yellower the hotter it is. @param heat 0 cold .. 1 hottest. Duplicated in opaque.frag.
Vec3f glow_of(const Vec3f& emission, float heat);
/// Heat (0 .. 1) of a crust, whose cracks stay hot for longer. @param age in units of Material::cooling
float heat_of_crust(float age);

/// Textures of solids and of the ground, numbered as in textures.glsl. paper: the ground continues the backdrop. picture: from a file.
enum class Pattern { paper = -1, plain = 0, wood_rings = 1, planks = 2, rock = 3, slab = 4, cloth = 5, picture = 6 };

/// Material of a solid.
struct SolidMaterial {
    Vec3f colour = Vec3f::Constant(0.7f);  ///< diffuse colour; of a metal, tint of its reflection
    float roughness = 0.3f;
    float metal = 0;  ///< 0 or 1
    Pattern pattern = Pattern::plain;
    float refraction = 0;              ///< index of refraction; 0: opaque
    Vec3f absorption = Vec3f::Zero();  ///< 1/m, of a solid that refracts
};
/// ceramic | white | metal | wood | clay | dark | rock | glass | ice | cloth; any other name: ceramic.
SolidMaterial solid_material(const std::string& name);
/// The material of that name with the values that the appearance overrides.
SolidMaterial solid_material(const Appearance& appearance);
std::vector<std::string> solid_material_names();
/// Material of the ground: none (paper) | plain | wood | stone | cloth; any other name: none.
SolidMaterial table_material(const std::string& name);
std::vector<std::string> table_names();

}  // namespace whorl

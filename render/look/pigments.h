#pragma once
/// Inks as painters mix them: light that goes through a layer of pigments is absorbed and scattered by each of them.
#include <array>
#include <string>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

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

/// "#rrggbb" -> sRGB, 0 .. 1. @return false where the text is no colour
bool read_colour(const std::string& text, Vec3f& colour);

}  // namespace whorl

#pragma once
/// Perceptual colour maps for fields on particles and slices.
#include <string>
#include <vector>

#include "engine/core/colour.h"

namespace whorl {

/// Colour of a map at t in [0, 1], sRGB 0 .. 1. viridis, inferno: lightness rises evenly with t. coolwarm, for signed values: blue, light
/// grey, red, equally light at t and 1 - t. Any other name: viridis.
Vec3f map_colour(const std::string& map, float t);
bool is_diverging(const std::string& map);
std::vector<std::string> colour_map_names();

/// Colours of a map in linear RGB, tabulated densely enough for linear interpolation.
class ColourTable {
public:
    explicit ColourTable(const std::string& map);
    /// @param t in [0, 1]
    Vec3f operator()(float t) const;

private:
    std::vector<Vec3f> colours_;
};

/// sRGB, 0 .. 1 -> CIE L*a*b* (D65).
Vec3f lab_of(const Vec3f& colour);

}  // namespace whorl

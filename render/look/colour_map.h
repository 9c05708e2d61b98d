#pragma once
/// Perceptual colour maps for fields on particles and slices.
#include <string>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// sRGB, 0 .. 1, at t in [0, 1]. viridis | inferno | coolwarm (diverging, for signed values); any other name: viridis.
Vec3f map_colour(const std::string& map, float t);
bool is_diverging(const std::string& map);
std::vector<std::string> colour_map_names();

}  // namespace whorl

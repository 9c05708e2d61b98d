#pragma once
/// What the particles carry, on the surface.
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// Means of the particles' values about each vertex, weights falling from 1 to 0 at `reach` [m]; 0 where none is that near.
std::vector<float> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> value, float reach);
std::vector<Vec3f> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const Vec3f> value, float reach);

}  // namespace whorl

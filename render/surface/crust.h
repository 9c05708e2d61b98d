#pragma once
/// What the crust of a cooling fluid is broken into: plates that go with the particles.
#include <array>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// At a vertex: how far it is from the nearest edge of its large plate and of its small plate [spacings], a number of its large plate's own
/// and a number that varies from particle to particle (both 0 to 1).
using CrustPlace = std::array<float, 4>;

/// Some of the particles are the middles of plates, chosen by their grains; a vertex belongs to the plate whose middle is nearest (Voronoi
/// cells, about seven and three spacings wide). The same particles are chosen in every frame, so a plate moves and deforms with the fluid.
/// @param vertex, particle m @param grain of each particle, 0 to 1 @param spacing m
std::vector<CrustPlace> crust_places(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> grain, float spacing);

}  // namespace whorl

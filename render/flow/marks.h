#pragma once
/// Marks over the colours of a slice: isolines, relief, arrows, streaks. None of them moves where the flow is at rest.
#include <array>
#include <vector>

#include "render/flow/plane_field.h"

namespace whorl {

/// Isolines at `count` values that divide the range into equal parts, about one pixel wide in 1280. They fade where the value is nearly
/// uniform, because a line would be a blotch there.
/// @param value per pixel @return share of line per pixel, 0 .. 1
std::vector<float> iso_lines(const PlaneField& field, const std::vector<float>& value, const std::array<float, 2>& range, int count);

/// Shading of the value as a landscape under a lamp at the upper left.
/// @param strength height of the range, in tenths of the longer side @return factor on the light per pixel, 1 where the value is uniform
std::vector<float> relief(const PlaneField& field, const std::vector<float>& value, const std::array<float, 2>& range, float strength);

/// Largest half-length of an arrow, over the distance between arrows.
constexpr float arrow_reach = 0.46f;
struct Arrows {
    std::vector<float> body;  ///< share of arrow per pixel, 0 .. 1
    std::vector<float> halo;  ///< share of arrow with a pale rim per pixel, 0 .. 1; the rim keeps an arrow visible on any colour
};
/// Arrows along the velocity, on a square lattice that is fixed in the plane.
/// @param count number along the longer side @param seconds flow time that each half of an arrow covers @param pixel edge of a pixel [m]
Arrows arrows(const PlaneField& field, int count, float seconds, float pixel);

/// Line integral convolution (Cabral and Leedom 1993): noise averaged along the flow. The noise moves with the particles, so streaks move
/// with the fluid from frame to frame.
/// @param seconds flow time that a streak covers upstream and downstream @param pixel edge of a pixel [m]
/// @return brightness per pixel: mean 0 and variance 1 where a streak is longer than three pixels, 0 where the flow is at rest
std::vector<float> streaks(const PlaneField& field, float seconds, float pixel);

}  // namespace whorl

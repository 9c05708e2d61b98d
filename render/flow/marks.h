#pragma once
/// Marks over a slice's colours: iso-lines, relief, arrows, streaks. All of them are still where the flow is at rest.
#include <array>
#include <vector>

#include "render/flow/plane_field.h"

namespace whorl {

/// Lines at `count` values that part the range evenly, about a pixel wide at 1280. They fade where the value is so even that a line would
/// be a blotch.
/// @param value of each pixel @return share of line in each pixel, 0 .. 1
std::vector<float> iso_lines(const PlaneField& field, const std::vector<float>& value, const std::array<float, 2>& range, int count);

/// The value as a landscape under a lamp at the upper left. @param strength 1: the range is a tenth of the longer side high
/// @return factor of each pixel's light, 1 where the value is even
std::vector<float> relief(const PlaneField& field, const std::vector<float>& value, const std::array<float, 2>& range, float strength);

/// Arrows on a square lattice that is fixed in the plane.
/// @param count of them along the longer side @param seconds of the flow's way to each side of an arrow's middle @param pixel its edge [m]
/// To each side an arrow reaches at most `arrow_reach` of the way to the next.
constexpr float arrow_reach = 0.46f;
struct Arrows {
    std::vector<float> body;  ///< share of arrow in each pixel, 0 .. 1
    std::vector<float> halo;  ///< the same of a rim, so that an arrow can be read on any colour
};
Arrows arrows(const PlaneField& field, int count, float seconds, float pixel);

/// Line integral convolution (Cabral and Leedom 1993): noise smeared along the flow. The noise moves with the particles, so streaks move
/// from frame to frame as the fluid does.
/// @param seconds of the flow's way to each side that a streak shows @param pixel its edge [m]
/// @return brightness of each pixel, mean 0 and variance 1 where the flow moves by more than a few pixels, 0 0 at rest
std::vector<float> streaks(const PlaneField& field, float seconds, float pixel);

}  // namespace whorl

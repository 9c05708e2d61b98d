#pragma once
/// Line integral convolution (Cabral and Leedom 1993): noise smeared along the flow, so that a still picture shows where it goes. The noise
/// goes with the particles: from picture to picture streaks move as the fluid does, and stand still where it does.
#include <vector>

#include "render/flow/plane_field.h"

namespace whorl {

/// @param seconds of the flow's way to each side that a streak shows @param pixel its edge [m]
/// @return brightness of each pixel, mean 0 and variance 1 where the flow moves by more than a few pixels, 0 where it stands still
std::vector<float> streaks(const PlaneField& field, float seconds, float pixel);

}  // namespace whorl

#pragma once
/// Line integral convolution (Cabral and Leedom 1993): noise smeared along the flow, so that a still picture shows where it goes.
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// @param velocity in the picture's own axes, nx x ny, row by row, any unit @param half_length of a streak to each side [pixels]
/// @return brightness about 1/2, 0 .. 1; the noise stands still from picture to picture
std::vector<float> streaks(const std::vector<Eigen::Vector2f>& velocity, int nx, int ny, int half_length);

}  // namespace whorl

#pragma once
/// Values at a point from values at scattered places.
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// Weights by least squares: sum_k weight_k f(place_k) is the value at 0 of the quadratic function of place that fits f best, with
/// Wendland's C2 function of |place|. So quadratic functions are exact, up to a wall too. Terms that the places do not tell apart are left
/// out.
/// @param place over the reach of the fit: |place| < 1; at least one
std::vector<double> fitted_at_origin(const std::vector<Vec3d>& place);
/// The same with the constant term alone: the mean.
std::vector<double> mean_at_origin(const std::vector<Vec3d>& place);

}  // namespace whorl

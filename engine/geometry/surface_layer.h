#pragma once
/// Particles on the surface of a shape: what the layer() of every shape is made of.
#include "engine/geometry/shape.h"

namespace whorl {

/// Half-lengths of the surface at `offset`: a body thinner than twice the offset gets its layer half way to its middle.
inline double inset(double half, double offset) { return offset < 0 ? std::max(half + offset, half / 2) : half + offset; }

/// Evenly spread over the period of the axis, half a step from its ends.
std::vector<double> period_points(const LayerRegion& region, int axis);

/// Two unit vectors that make a right-handed frame with the unit vector n.
void frame_of(const Vec3d& n, Vec3d& u, Vec3d& v);

/// @throws InputError beyond 50 million points
void check_count(double points, const std::string& shape);

}  // namespace whorl

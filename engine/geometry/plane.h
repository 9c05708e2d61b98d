#pragma once
/// The half-space below a plane.
#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_plane(const Vec3d& point, const Vec3d& normal);

/// How many points the layer of a plane with this normal has where the region does not clip it.
double plane_points(const Vec3d& normal, const LayerRegion& region);

}  // namespace whorl

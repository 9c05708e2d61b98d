#pragma once
/// The half-space below a plane.
#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_plane(const Vec3d& point, const Vec3d& normal);

}  // namespace whorl

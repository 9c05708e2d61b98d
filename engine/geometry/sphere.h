#pragma once
/// A ball.
#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_sphere(const Vec3d& centre, double radius);

}  // namespace whorl

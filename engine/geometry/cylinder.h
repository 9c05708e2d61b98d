#pragma once
/// A round cylinder with flat ends.
#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_cylinder(const Vec3d& from, const Vec3d& to, double radius);

}  // namespace whorl

#pragma once
/// A box with its edges along the axes.
#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_box(const Vec3d& min, const Vec3d& max);

}  // namespace whorl

#pragma once
/// Solids of revolution, with exact signed distances.
#include "engine/geometry/shape.h"

namespace whorl {

/// All points at most `radius` [m] from the segment between the points.
std::shared_ptr<const Shape> make_capsule(const Vec3d& from, const Vec3d& to, double radius);
/// A cone, cut off where its radius is end_radius. @param radius of the end at `from` [m] @param end_radius of the end at `to`; 0: a tip
std::shared_ptr<const Shape> make_cone(const Vec3d& from, const Vec3d& to, double radius, double end_radius);
/// All points at most `tube` [m] from a circle of the given radius about the axis. @param tube less than radius
std::shared_ptr<const Shape> make_torus(const Vec3d& centre, const Vec3d& axis, double radius, double tube);

}  // namespace whorl

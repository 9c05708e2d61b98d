#pragma once
/// The kinds of shapes, one file each; make_shape() chooses.
#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_box(const Vec3d& min, const Vec3d& max);
std::shared_ptr<const Shape> make_sphere(const Vec3d& centre, double radius);
/// With flat ends at `from` and `to`.
std::shared_ptr<const Shape> make_cylinder(const Vec3d& from, const Vec3d& to, double radius);
/// The half-space below the plane through `point`.
std::shared_ptr<const Shape> make_plane(const Vec3d& point, const Vec3d& normal);
/// The closed mesh in `file`, times scale, then moved by `position`. @throws InputError
std::shared_ptr<const Shape> make_mesh(const std::filesystem::path& file, double scale, const Vec3d& position);
/// The same for a mesh in memory; `name` stands in the error message. @throws InputError where it is empty or not closed
std::shared_ptr<const Shape> make_mesh(TriangleMesh mesh, const std::string& name);

/// Two unit vectors that make a right-handed frame with the unit vector n.
void frame_of(const Vec3d& n, Vec3d& u, Vec3d& v);

}  // namespace whorl

#pragma once
/// What a closed triangle mesh holds.
#include "engine/geometry/shape.h"

namespace whorl {

/// The mesh in `file`, times scale, then moved by `position`. @throws InputError
std::shared_ptr<const Shape> make_mesh(const std::filesystem::path& file, double scale, const Vec3d& position);
/// The same for a mesh in memory; `name` stands in the error message. @throws InputError where it is empty or not closed
std::shared_ptr<const Shape> make_mesh(TriangleMesh mesh, const std::string& name);

}  // namespace whorl

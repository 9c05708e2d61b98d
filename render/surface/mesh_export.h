#pragma once
/// Meshes as files that other programs open. Both appear whole or not at all. @throws EnvironmentError
#include <filesystem>

#include "engine/core/mesh.h"

namespace whorl {

/// Binary little-endian PLY with normals where the mesh has them.
void write_ply_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);
/// Wavefront OBJ with normals where the mesh has them.
void write_obj_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace whorl

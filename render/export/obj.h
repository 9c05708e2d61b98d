#pragma once
/// Meshes as Wavefront OBJ.
#include <filesystem>

#include "engine/core/mesh.h"

namespace whorl {

/// With normals where the mesh has them, and nothing else: OBJ has no place for it. Whole or not at all. @throws EnvironmentError
void write_obj_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace whorl

#pragma once
/// Particles and meshes as PLY, meshes as Wavefront OBJ.
#include <array>
#include <filesystem>

#include "engine/core/mesh.h"
#include "render/export/attributes.h"

namespace whorl {

/// Binary little-endian PLY, one vertex a row. Every property is a float or an int of four bytes, by component_names(). Comments give the
/// frame and the units. Whole or not at all. @throws EnvironmentError
/// @param triangles null: points, no faces
void write_ply(const std::filesystem::path& file, const Frame& frame, const Attributes& vertices,
               const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr);

/// With normals where the mesh has them, and nothing else: OBJ has no place for it. Whole or not at all. @throws EnvironmentError
void write_obj_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace whorl

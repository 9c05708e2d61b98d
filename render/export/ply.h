#pragma once
/// Particles and meshes as PLY, meshes as Wavefront OBJ.
#include <array>
#include <filesystem>

#include "engine/core/mesh.h"
#include "render/export/attributes.h"

namespace whorl {

/// Atomically writes a binary little-endian PLY file, one vertex per row. Every property is a 4-byte float or int, named by
/// component_names(). Comments in the file give the frame and the units. @throws EnvironmentError
/// @param triangles null: points, no faces
void write_ply(const std::filesystem::path& file, const Frame& frame, const Attributes& vertices,
               const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr);

/// Atomically writes the positions and triangles of a mesh, and its normals if it has any. OBJ has no other fields. @throws
/// EnvironmentError
void write_obj_mesh(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace whorl

#pragma once
/// Texture coordinates of a solid's mesh.
#include <filesystem>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl {

/// Texture coordinates (OBJ vt, v up) of the three corners of each triangle. The drawn mesh is that of the file, scaled and displaced;
/// triangles are found by their positions in the bounds. Empty if the file is not an OBJ file with texture coordinates, or if the meshes
/// differ.
std::vector<Eigen::Vector2f> texture_places(const TriangleMesh& mesh, const std::filesystem::path& file);

}  // namespace whorl

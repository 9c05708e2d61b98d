#pragma once
/// Readers of triangle meshes: OBJ, PLY (ascii, binary little endian), STL (ascii, binary).
#include <filesystem>

#include "engine/core/mesh.h"

namespace whorl {

/// Positions and triangles only; polygons become fans, equal positions one vertex, triangles without an area of their own (two equal
/// corners) go.
/// @throws InputError with file:line where the file is missing, of an unknown kind, cut short or refers to vertices that it does not have
TriangleMesh read_mesh(const std::filesystem::path& file);

/// Makes equal positions one vertex and drops triangles with two equal corners, normals and scalars.
void weld(TriangleMesh& mesh);

}  // namespace whorl

#pragma once
/// Triangle meshes: parts, and readers of OBJ, PLY (ascii, binary little endian), STL (ascii, binary).
#include <filesystem>
#include <string>

#include "engine/core/mesh.h"

namespace whorl {

/// Positions and triangles only; polygons become fans, equal positions one vertex, triangles without an area of their own (two equal
/// corners) go.
/// @throws InputError with file:line where the file is missing, of an unknown kind, cut short or refers to vertices that it does not have
TriangleMesh read_mesh(const std::filesystem::path& file);

/// Makes equal positions one vertex and drops triangles with two equal corners, normals and scalars.
void weld(TriangleMesh& mesh);

/// Adds the vertices, normals and triangles of another mesh.
void append(TriangleMesh& to, const TriangleMesh& more);

/// The closed parts of a welded mesh, each with its own vertices, looking outward; one alone is the mesh itself.
/// @throws InputError where the mesh has holes, or neighbours look different ways
std::vector<TriangleMesh> closed_parts(TriangleMesh mesh, const std::string& name);

}  // namespace whorl

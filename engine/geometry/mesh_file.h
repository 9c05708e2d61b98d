#pragma once
/// Triangle meshes: parts, and readers of OBJ, PLY, STL (ascii and binary) and glTF.
#include <filesystem>
#include <string>

#include "engine/core/mesh.h"

namespace whorl {

/// Positions, times scale, then moved by `position` [m] (in double precision), and triangles; polygons may be concave.
/// @throws InputError with file:line if the file is missing, of an unknown kind, truncated, refers to missing vertices, or
/// is too far from the origin: single precision rounds its coordinates to more than 1/1000 of its size
TriangleMesh read_mesh(const std::filesystem::path& file, double scale = 1, const Vec3d& position = Vec3d::Zero());

/// Makes equal positions one vertex and drops triangles with two equal corners, normals and scalars.
void weld(TriangleMesh& mesh);

/// Adds the vertices, normals and triangles of another mesh.
void append(TriangleMesh& to, const TriangleMesh& more);

/// The closed parts of a welded mesh that have a volume, each with its own vertices, looking outward.
/// @param left_out gets a line for faces that are there twice, and for parts without a volume
/// @throws InputError if the mesh has holes, or neighbours look different ways, or it has no volume
std::vector<TriangleMesh> closed_parts(TriangleMesh mesh, const std::string& name, std::vector<std::string>& left_out);

}  // namespace whorl

#pragma once
/// Triangle meshes: readers of OBJ, PLY, STL (ascii and binary) and glTF, and closed parts.
#include <filesystem>
#include <string>

#include "engine/core/mesh.h"

namespace whorl {

/// Reads a mesh. Its positions are multiplied by `scale`, then moved by `position` [m], in double precision. Polygons, which may be
/// concave, become triangles. @param node of a glTF file: only the meshes of this node and its children, in the axes of the node
/// @throws InputError with file:line if the file is missing, of an unknown kind, truncated, or refers to missing vertices. Also if the mesh
/// is so far from the origin that single precision rounds its coordinates by more than 1/1000 of its size
TriangleMesh read_mesh(const std::filesystem::path& file, double scale = 1, const Vec3d& position = Vec3d::Zero(),
                       const std::string& node = "");

/// Merges vertices at equal positions. Removes triangles with two equal corners, and all normals and scalars.
void weld(TriangleMesh& mesh);

/// Appends the vertices, normals and triangles of another mesh.
void append(TriangleMesh& to, const TriangleMesh& more);

/// Splits a polygon into triangles by ear clipping in the plane perpendicular to its area vector. The polygon may be concave, and may have
/// holes that a bridge joins to the rim. A convex polygon becomes a fan from its first corner. The triangles of a self-intersecting polygon
/// cover each point as often, with sign, as the polygon winds around it. @param x vertices @param ring the polygon's vertices, in order
/// @param to receives the triangles
void triangulate(const std::vector<Vec3d>& x, std::vector<std::uint32_t> ring, std::vector<std::array<std::uint32_t, 3>>& to);

/// Splits a welded mesh into its closed parts with a volume, each with its own vertices and oriented outward.
/// @param left_out receives a line on duplicate faces, and one on parts without a volume
/// @throws InputError if the mesh has holes, adjacent faces with opposite orientations, or no volume
std::vector<TriangleMesh> closed_parts(TriangleMesh mesh, const std::string& name, std::vector<std::string>& left_out);

}  // namespace whorl

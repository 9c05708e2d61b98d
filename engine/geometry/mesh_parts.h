#pragma once
/// Triangle meshes of several parts.
#include <string>

#include "engine/core/mesh.h"

namespace whorl {

/// Adds the vertices, normals and triangles of another mesh.
void append(TriangleMesh& to, const TriangleMesh& more);

/// The closed parts of a welded mesh, each with its own vertices, looking outward; one alone is the mesh itself.
/// @throws InputError where the mesh has holes, or neighbours look different ways
std::vector<TriangleMesh> closed_parts(TriangleMesh mesh, const std::string& name);

}  // namespace whorl

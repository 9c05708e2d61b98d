#pragma once
/// Where a mesh has sharp edges: normals for meshes that bring none, and the edges themselves.
#include <utility>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl {

/// The mesh with a normal for every corner: faces that meet at less than 40 degrees share one. Meshes that have normals come back as they
/// are.
TriangleMesh with_normals(const TriangleMesh& mesh);

/// Edges of a mesh where its faces meet at more than 40 degrees, or that only one face has: pairs of ends.
std::vector<std::pair<Vec3f, Vec3f>> sharp_edges(const TriangleMesh& mesh);

}  // namespace whorl

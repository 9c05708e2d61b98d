#pragma once
/// Normals for meshes that bring none.
#include "engine/core/mesh.h"

namespace whorl {

/// The mesh with a normal for every corner: faces that meet at less than 40 degrees share one. Meshes that have normals come back as they
/// are.
TriangleMesh with_normals(const TriangleMesh& mesh);

}  // namespace whorl

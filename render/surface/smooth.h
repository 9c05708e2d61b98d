#pragma once
/// Smoothing of a closed mesh that keeps its volume.
#include "engine/core/mesh.h"

namespace whorl {

/// Takes out bumps of the size of the particles' distance.
/// @param steps of each blur: 10 where edges are half a spacing long, more in proportion to the inverse square of their length
void smooth(TriangleMesh& mesh, int rounds, int steps);

/// Normals from the mesh itself, weighted by area.
void set_normals(TriangleMesh& mesh);
/// Normals of the same mesh after a blur of so many steps: what it mirrors gets clean edges, and its outline stays. That the blur shrinks
/// it does not show in its normals.
void set_smooth_normals(TriangleMesh& mesh, int steps);

}  // namespace whorl

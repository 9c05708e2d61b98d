#pragma once
/// Meshes of curved solids as smooth as their normals.
#include "engine/core/mesh.h"

namespace whorl {

/// The mesh with edges split where the surface that its normals describe lies farther than `off` [m] from them, up to three times. The
/// middle of an edge from x_a to x_b moves to
///     (x_a + x_b)/2 - ((n_a . e) n_a - (n_b . e) n_b)/8,   e = x_b - x_a,
/// on the cubic curve with those normals (Vlachos et al. 2001, doi:10.1145/364338.364387), which is exact on spheres and cylinders to the
/// fourth power of the angle. At a crease, where normals differ, the more curved face decides: a closed mesh stays closed. A mesh without
/// normals is returned unchanged. The result has no scalars.
TriangleMesh rounded(TriangleMesh mesh, float off);

}  // namespace whorl

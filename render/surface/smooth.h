#pragma once
/// Smoothing of a closed mesh that keeps its volume.
#include <utility>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl {

/// Removes bumps as small as the distance between particles.
/// @param steps of each blur: 10 where edges are half a spacing long, more in proportion to the inverse square of their length
/// @param bulk of each vertex, 0 .. 1: rounds after the first move it by that share, so that drops and thin threads keep their size
/// (Loeschner et al. 2023 weight by the number of particles); empty: all rounds move vertices fully
/// @param sides how many walls each vertex is on: the line where the surface meets walls is smoothed along itself; empty: none
void smooth(TriangleMesh& mesh, int rounds, int steps, const std::vector<float>& bulk = {}, const std::vector<char>& sides = {});

/// Area-weighted normals of the mesh after a blur of `steps` steps (0: of the mesh itself), for clean edges of reflections. The mesh keeps
/// its outline, and the shrinking by the blur does not affect the normals. @param further steps, weighted by `bulk`
void set_smooth_normals(TriangleMesh& mesh, int steps, int further = 0, const std::vector<float>& bulk = {},
                        const std::vector<char>& sides = {});

/// Edges at which faces meet at more than 40 degrees, or that only one face has, as pairs of end points.
std::vector<std::pair<Vec3f, Vec3f>> sharp_edges(const TriangleMesh& mesh);

}  // namespace whorl

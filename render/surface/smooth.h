#pragma once
/// Smoothing of a closed mesh that keeps its volume.
#include <utility>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl {

/// Takes out bumps of the size of the particles' distance.
/// @param steps of each blur: 10 where edges are half a spacing long, more in proportion to the inverse square of their length
/// @param bulk of each vertex, 0 .. 1: rounds after the first move it by that share, so that drops and thin threads keep their size (as
/// Loeschner et al. 2023 weigh by the number of particles); empty: all by the whole
/// @param sides how many walls each vertex is on: the line where the surface meets walls is smoothed along itself; empty: none
void smooth(TriangleMesh& mesh, int rounds, int steps, const std::vector<float>& bulk = {}, const std::vector<char>& sides = {});

/// Normals, weighted by area, of the mesh after a blur of `steps` steps (0: of the mesh itself): reflections get clean edges, and the
/// outline is unchanged. The shrinking by the blur does not affect the normals. @param further steps, weighted by `bulk`
void set_smooth_normals(TriangleMesh& mesh, int steps, int further = 0, const std::vector<float>& bulk = {},
                        const std::vector<char>& sides = {});

/// Edges of a mesh where its faces meet at more than 40 degrees, or that only one face has: pairs of ends.
std::vector<std::pair<Vec3f, Vec3f>> sharp_edges(const TriangleMesh& mesh);

}  // namespace whorl

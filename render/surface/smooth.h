#pragma once
/// Smoothing of a closed mesh that keeps its volume.
#include <utility>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl {

/// Removes bumps as small as the distance between particles.
/// @param steps per blur: 10 if edges are half a spacing long, otherwise in proportion to the inverse square of their length
/// @param bulk per vertex, 0 .. 1, factor on its movement in all rounds after the first, so that drops and thin threads keep their size
/// (Loeschner et al. 2023 weight by the number of particles); empty: 1. The first round smooths these factors too, because a vertex that
/// stays while its neighbours move is a notch.
/// @param sides per vertex, number of sides that it is on; empty: 0. Vertices on the line where the surface meets walls move only along it.
/// @return the smoothed factors
std::vector<float> smooth(TriangleMesh& mesh, int rounds, int steps, const std::vector<float>& bulk = {},
                          const std::vector<char>& sides = {});

/// Normals of the mesh after a blur of `steps` steps (0: of the mesh itself), for clean edges of reflections: area-weighted, then averaged
/// with those of the neighbours that are not on walls. The positions do not change, and the shrinking by the blur does not affect the
/// normals. @param further number of further steps, weighted by `bulk`, the factors that smooth() returns
void set_smooth_normals(TriangleMesh& mesh, int steps, int further = 0, const std::vector<float>& bulk = {},
                        const std::vector<char>& sides = {});

/// Edges at which faces meet at more than 40 degrees, or that only one face has, as pairs of end points.
std::vector<std::pair<Vec3f, Vec3f>> sharp_edges(const TriangleMesh& mesh);

}  // namespace whorl

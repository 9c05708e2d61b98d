#pragma once
/// Mesh -> dense signed distance volume.
#include "render/surface/surface.h"

namespace whorl {

/// Signed distance to a closed mesh, negative inside, clamped to `band` voxels either way. Exact near the surface; further off the distance to the
/// closest point that the neighbours know (an upper bound, good to some per cent). The volume covers the mesh and two voxels
/// round it; where that would take more than 16 million voxels it is made coarser.
Volume distance_volume(const TriangleMesh& mesh, float voxel, int band);

}  // namespace whorl

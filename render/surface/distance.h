#pragma once
/// Mesh -> dense signed distance volume.
#include "render/surface/surface.h"

namespace whorl {

/// Signed distance to a closed mesh, negative inside, clamped to `band` voxels either way. Exact within 1.75 voxels of the surface; further
/// off the distance to a point of the surface that is the closest or beside it (an upper bound, good to 0.15 of a voxel). The volume covers
/// the mesh and two voxels round it; where that would take more than 16 million voxels it is made coarser.
/// (openvdb::tools::meshToVolume takes five to eight times as long on the mesh of a coil, and is off by up to 0.6 of a voxel.)
Volume distance_volume(const TriangleMesh& mesh, float voxel, int band);

}  // namespace whorl

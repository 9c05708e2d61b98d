#pragma once
/// Particles -> density-normalised colour field in an OpenVDB grid -> closed triangle mesh and a distance volume. OpenVDB stays behind
/// this header: including it costs nothing.
#include <filesystem>
#include <memory>
#include <vector>

#include "engine/io/frame.h"

namespace whorl {

struct SurfaceOptions {
    double voxel = 0.5;    ///< edge of a voxel over the spacing
    double radius = 2.0;   ///< kernel radius over the spacing; up to 1.2 times that where particles have little company
    double iso = 0.605;    ///< the colour field's value on the surface, near 1 inside; 0.605: unbiased (render/surface/colour_field.h)
    int smoothing = 1;     ///< rounds of smoothing on the mesh that keep its volume; 0: none
    bool distance = true;  ///< make the distance volume (refraction needs it)
};

/// A dense scalar volume: value at voxel (i,j,k) stands at origin + voxel (i,j,k); index = (k ny + j) nx + i.
struct Volume {
    Vec3f origin = Vec3f::Zero();  ///< m
    float voxel = 0;               ///< m
    int nx = 0, ny = 0, nz = 0;
    std::vector<float> value;
};

struct Surface {
    TriangleMesh mesh;       ///< closed, manifold, outward normals
    std::vector<float> age;  ///< s, one a vertex: how long the fluid there has been about; empty where the frame does not say
    Volume distance;         ///< signed distance to the surface [m], negative inside, clamped to a band of some voxels
};

/// Builds the surface of the frame's fluid. The same bits for any number of threads. An empty frame gives an empty surface.
Surface build_surface(const Frame& frame, const SurfaceOptions& options);

/// Writes a .vdb file that other programs open: a level set "surface" and a fog volume "density", plus the named vector field "velocity".
void write_vdb(const std::filesystem::path& file, const Frame& frame, const SurfaceOptions& options);

}  // namespace whorl

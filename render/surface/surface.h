#pragma once
/// Particles -> density-normalised colour field in an OpenVDB grid -> closed triangle mesh and a distance volume. This header does not
/// include OpenVDB.
#include <vector>

#include "engine/core/grid_index.h"
#include "engine/io/frame.h"
#include "render/surface/vertex_values.h"

namespace whorl {

struct SurfaceOptions {
    double voxel = 0.5;     ///< edge of a voxel [spacings]
    double radius = 2.0;    ///< kernel radius [spacings]; up to 1.2 times that for particles with few neighbours
    double iso = 0.605;     ///< the colour field's value on the surface, near 1 inside; 0.605: unbiased (render/surface/colour_field.h)
    int smoothing = 8;      ///< rounds of smoothing on the mesh that keep its volume; 0: none
    bool distance = true;   ///< make the distance volume (refraction needs it)
    bool velocity = false;  ///< compute the velocity at the vertices; no key: needed by cameras with an open shutter and by EXR images
    bool ages = true;       ///< compute ages and crust if the frame has ages or temperatures; no key: false if nothing depends on them
};

/// The keys of [surface] in a scene file.
const class KeyTable& surface_keys();

/// A dense scalar volume: value at voxel (i,j,k) is at origin + voxel (i,j,k); i runs fastest.
struct Volume {
    Vec3f origin = Vec3f::Zero();  ///< m
    float voxel = 0;               ///< m
    int nx = 0, ny = 0, nz = 0;
    std::vector<float> value;
    std::size_t count() const { return grid_count(nx, ny, nz); }
    std::size_t index(int i, int j, int k) const { return grid_index(i, j, k, nx, ny); }
    Vec3f at(int i, int j, int k) const {
        return origin + voxel * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
    }
};

struct Surface {
    TriangleMesh mesh;                  ///< closed, manifold, outward normals
    std::vector<Index> edge;            ///< vertices without a unique normal, where two walls or surface and wall meet; ascending
    std::vector<float> age;             ///< s, one per vertex: age of the fluid there; empty if the frame has no ages
    bool glows_by_temperature = false;  ///< `age` is then the age over Material::cooling of lava that glows as lava of this temperature
    std::vector<Vec3f> velocity;        ///< m/s, one per vertex; empty if not requested
    Crust crust;                        ///< empty if the frame has no ages or no particle identities
    Volume distance;                    ///< signed distance to the surface [m], negative inside, clamped to a narrow band
};

/// Builds the surface of the frame's fluid, bit-identical for any number of threads. An empty frame gives an empty surface.
Surface build_surface(const Frame& frame, const SurfaceOptions& options);

/// The mesh without slivers (triangles of nearly zero area) and coincident vertices. They arise where vertices are moved onto an edge
/// between walls. The shortest edge of a sliver collapses to its vertex of lower index. The mesh stays closed and manifold. `mesh.scalar`
/// must be empty.
TriangleMesh without_slivers(TriangleMesh mesh);

/// Signed distance to a closed mesh, negative inside, clamped to +-`band` voxels. Exact within 1.75 voxels of the surface. Farther away it
/// is the distance to a point of the surface at or near the closest one, so it is at most 0.15 voxel too large. The volume covers the mesh
/// and two voxels around it. Voxels are larger than requested if there would be more than 16 million. (openvdb::tools::meshToVolume needs
/// five to eight times as long for the mesh of a coil, with errors of up to 0.6 voxel.)
Volume distance_volume(const TriangleMesh& mesh, float voxel, int band);

}  // namespace whorl

#pragma once
/// Surfaces from formulas: fixed meshes for images, without a simulation.
#include <functional>

#include "engine/io/frame.h"
#include "render/surface/surface.h"

namespace whorl::test {

/// Signed distance of a shape [m], negative inside.
using ShapeDistance = std::function<float(const Vec3f&)>;

/// Samples the distance in the box [low, high] and meshes its zero by marching tetrahedra.
Surface surface_of(const ShapeDistance& distance, const Vec3f& low, const Vec3f& high, float voxel);

/// Calls f(position, value) at every node.
template <class F>
void each_node(const Volume& v, const F& f) {
    for (int k = 0; k < v.nz; ++k)
        for (int j = 0; j < v.ny; ++j)
            for (int i = 0; i < v.nx; ++i) f(v.at(i, j, k), v.value[v.index(i, j, k)]);
}

/// Trilinear.
float interpolated(const Volume& v, const Vec3f& x);

/// A thread of honey that falls from `height` into a coiled heap on the plane y = 0: coils of radius `coil`, thread radius `radius` [m].
Surface coiled_thread(float radius, float coil, int turns, float height, float voxel);
Surface sphere(const Vec3f& centre, float radius, float voxel);
/// A square pool on y = 0 with waves and a hump in the middle.
Surface pool(float half_width, float depth, float voxel);

/// Positions d (i, j, k), i outermost.
std::vector<Vec3f> lattice(int nx, int ny, int nz, float d);

/// A solid with this mesh. @param material "": the look's default
FrameSolid solid_of(TriangleMesh mesh, const std::string& material = "", bool container = false);

/// A board of dark and white tiles, 20 times 20, whose top is at y = 0. The tile from (0, 0) to (tile, tile) [m] in x and z is dark.
std::vector<FrameSolid> chequered_board(float tile);

/// A closed box, cylinder (with its axis along y) and tube as solids for drawing.
TriangleMesh box_mesh(const Vec3f& low, const Vec3f& high);
TriangleMesh cylinder_mesh(const Vec3f& base, float radius, float height);

}  // namespace whorl::test

#pragma once
/// Measures of a surface: closed and manifold, distance from the shape that the particles fill, roughness, steadiness.
#include <vector>

#include "engine/core/mesh.h"
#include "engine/io/frame.h"

namespace whorl::test {

struct Topology {
    bool closed = false;    ///< every edge belongs to exactly two triangles, which run along it in opposite directions
    bool manifold = false;  ///< closed, and the triangles round every vertex form one fan
    int components = 0;
    int euler = 0;  ///< vertices - edges + triangles; 2 for each sphere, 0 for each torus
};
Topology topology(const TriangleMesh& mesh);
double volume(const TriangleMesh& mesh);

/// Frames of blue-noise particles, spacing 1, that fill a shape (engine/particles/sample.h).
Frame sphere_frame(double radius, std::uint64_t seed);
Frame cylinder_frame(double radius, double length, std::uint64_t seed);
/// A square pool: its top at y = 0.
Frame pool_frame(double width, double depth, bool jittered_lattice, std::uint64_t seed);
/// Particles along a curve of the given radius: y rises along a spiral of `turns`.
Frame coil_frame(double thread_radius, double coil_radius, double pitch, double turns, std::uint64_t seed);
/// A single file of particles along x.
Frame file_frame(double distance, int count);

struct Deviation {
    double mean = 0, rms = 0;  ///< mean distance of the surface from the shape of the particles' volume, and its spread about the mean
};
/// Mean over the mesh's area, without the ends of a cylinder (two radii and two spacings).
Deviation sphere_deviation(const TriangleMesh& mesh, const Frame& frame);
Deviation cylinder_deviation(const TriangleMesh& mesh, const Frame& frame, double length);

/// The top surface over a square lattice of points in the middle of a pool.
std::vector<double> heights(const TriangleMesh& mesh, const Vec3f& centre, double half_width, double step);
Deviation deviation(const std::vector<double>& values);

}  // namespace whorl::test

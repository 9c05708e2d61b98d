#pragma once
/// Helpers of Shape::surface_samples(): lattices of boundary particles on surfaces.
#include "engine/geometry/shape.h"

namespace whorl {

/// Half-length (or radius) of a shape after its surface is moved outward by `offset` (negative: inward); at least half / 2.
inline double inset(double half, double offset) { return offset < 0 ? std::max(half + offset, half / 2) : half + offset; }

/// Evenly spaced coordinates over the period of the axis [m], half a step from its ends.
std::vector<double> period_points(const SamplingRegion& region, int axis);

/// Whether x is in the region and, along periodic axes, within the domain. Of all periodic copies of a point this holds for exactly one.
bool contains_once(const SamplingRegion& region, const Vec3d& x);

/// Coordinates, along one axis, of the lattice on the surface at signed distance `offset` from a box; both ends included. If the box spans
/// a period of the axis, the coordinates cover the period and there are no ends.
struct LatticeLine {
    std::vector<double> at;  ///< m
    std::vector<int> side;   ///< -1 at the low end, 1 at the high end, 0 between
    /// Step to the next entry on the surface. @param on_face whether this line lies in a face, so that all its entries are on the surface;
    /// otherwise only its two ends are
    std::size_t next(bool on_face) const { return on_face ? 1 : std::max<std::size_t>(1, at.size() - 1); }
};
LatticeLine lattice_line(const SamplingRegion& region, int axis, double centre, double half, double offset, const std::string& shape);

/// SurfaceSample::face of a point on a box. @param side per axis, see LatticeLine
inline Vec3d face_of(const Vec3d& side) {
    for (int a = 0; a < 2; ++a)
        if (side[a] != 0 && side.squaredNorm() > 1) return side[a] * Vec3d::Unit(a);
    return Vec3d::Zero();
}

/// Unit vectors u, v so that (u, v, n) is right-handed. @param n unit vector
void frame_of(const Vec3d& n, Vec3d& u, Vec3d& v);

/// @throws InputError if `points` exceeds 50 million
void check_count(double points, const std::string& shape);

}  // namespace whorl

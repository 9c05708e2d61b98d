#pragma once
/// Particles on the surface of a shape: what the layer() of every shape is made of.
#include "engine/geometry/shape.h"

namespace whorl {

/// Half-lengths of the surface at `offset`: a body thinner than twice the offset gets its layer half way to its middle.
inline double inset(double half, double offset) { return offset < 0 ? std::max(half + offset, half / 2) : half + offset; }

/// Evenly spread over the period of the axis, half a step from its ends.
std::vector<double> period_points(const LayerRegion& region, int axis);

/// Whether the point is in the region, and within the domain along its periodic axes: what has no end is there once.
bool contains_once(const LayerRegion& region, const Vec3d& x);

/// Places along an axis of a box's surface at `offset`, from end to end; over the whole period, without ends, where the box spans it.
struct LatticeLine {
    std::vector<double> at;  ///< m
    std::vector<int> side;   ///< -1 at the low end, 1 at the high one, 0 between
    /// From one place to the next that is on the surface: across an inside only the two ends are. @param on_face all places are
    std::size_t next(bool on_face) const { return on_face ? 1 : std::max<std::size_t>(1, at.size() - 1); }
};
LatticeLine lattice_line(const LayerRegion& region, int axis, double centre, double half, double offset, const std::string& shape);

/// LayerPoint::face on a box. @param side by axis, see LatticeLine
inline Vec3d face_of(const Vec3d& side) {
    for (int a = 0; a < 2; ++a)
        if (side[a] != 0 && side.squaredNorm() > 1) return side[a] * Vec3d::Unit(a);
    return Vec3d::Zero();
}

/// Two unit vectors that make a right-handed frame with the unit vector n.
void frame_of(const Vec3d& n, Vec3d& u, Vec3d& v);

/// @throws InputError beyond 50 million points
void check_count(double points, const std::string& shape);

}  // namespace whorl

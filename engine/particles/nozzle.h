#pragma once
/// Opening of an emitter, and the pipe behind it.
#include <cmath>

#include "engine/geometry/solids.h"

namespace whorl {

struct EmitterShape {
    bool slot = false;                ///< a rectangle, width x thickness; otherwise a disc
    Vec3 centre = Vec3::Zero();       ///< centre of the opening [m]
    Vec3 direction = -Vec3::UnitY();  ///< direction of the flow, unit vector
    Real radius = 0;                  ///< m
    Real width = 0, thickness = 0;    ///< m
    bool parabolic = false;           ///< parabolic profile; otherwise a plug
    bool plane = false;               ///< 2D flow: a slot of width `width` in the plane z = 0, one metre deep

    /// The opening with its rim moved inward by `by` [m].
    EmitterShape narrower(Real by) const;
};

/// Unit axes of the opening: `width` along a slot's width (horizontal; along x if the flow is vertical) and `thickness` along its
/// thickness, with width x thickness = -direction. In 2D `thickness` is z.
inline void opening_axes(const EmitterShape& opening, Vec3& width, Vec3& thickness) {
    const Vec3 back = -opening.direction;
    if (opening.plane) {
        width = Vec3::UnitZ().cross(back), thickness = Vec3::UnitZ();
        return;
    }
    width = std::abs(back.y()) < Real(0.9) ? Vec3(Vec3::UnitY().cross(back)) : Vec3(Vec3::UnitX() - back.x() * back);
    width.normalize();
    thickness = back.cross(width);
}

/// Number of particles in the column that a nozzle repeats. For the streamlines of a parabolic profile it is one layer. For a plug it is 24
/// layers, or fewer (at least 6) if 24 layers would contain more than a hundred thousand particles.
/// @param area area of the opening [m^2]; in 2D its width [m]
double column_points(double area, double spacing, bool parabolic, int dimensions);

/// The pipe behind an opening: `depth` [m] of fluid, and a closed end of least_clearance spacings, which keeps other fluid away from the
/// places at which particles enter. @param domain its periodic axes repeat the pipe
Solid nozzle_body(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain);
/// A wider and longer version of the end of that pipe, in which new particles appear. It keeps other fluid so far away that new particles
/// cause no jump of the density of that fluid.
Solid nozzle_end(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain);
/// Length of that pipe [m], such that a particle at the opening has a complete neighbourhood.
inline Real nozzle_depth(double support, double spacing) { return static_cast<Real>(support + spacing); }

/// Signed distance to the wall of the pipe behind the opening. @param q position in the opening's frame: width, thickness, along the flow
Real pipe_distance(const EmitterShape& shape, const Vec3& q);
/// m^2; in 2D the width [m].
double opening_area(const EmitterShape& shape);

}  // namespace whorl

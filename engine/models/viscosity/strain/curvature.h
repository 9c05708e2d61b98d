#pragma once
/// Term that makes an implicit strain second order in time (docs/physics.md 4).
///
/// A step uses strain rates at its start, with the new velocities, and then moves every particle along a straight line. A rigid rotation
/// has no strain rate in the middle of that move. At its start the same velocities appear to shrink the body across the axis, at the rate
/// dt w^2/2. T is this part, for a motion that continues unchanged. With G the gradient of the velocities at the start of the step, the
/// last step's deformation is A = (1 - dt G)^-1. The same deformation once more has the gradient B/dt at its start and H in its middle,
///   B = A - 1,   H = 2/dt B (2 + B)^-1,   T = sym(B/dt - H) = sym(B^2 (2 + B)^-1)/dt = dt/2 sym(G G) + O(dt^2).
/// So mu D:D becomes mu (D - T):(D - T). The stress 2 mu T acts through the transpose of the gradient, as that of D does: it is symmetric
/// and opposite in each pair, so momentum and angular momentum are conserved.
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/sph/gate.h"

namespace whorl {

namespace field {
struct velocity_gradient {
    using type = Mat3;
    static constexpr std::string_view name = "velocity_gradient", unit = "1/s", meaning = "first-order gradient of the velocity";
};
}  // namespace field

/// T [1/s]. Exact for a rotation at constant rate. dt |G| is limited to 0.4 (0.28 radian per step), and T to 0.2 |G|.
Mat3 curvature_strain(const Mat3& G, Real dt);

/// Across directions that the neighbours do not resolve G has no columns. The fluid is assumed to rotate rigidly with the resolved
/// directions; otherwise a rotating line of particles would have no T along itself.
/// @param P Moment::resolved
Mat3 turned_rigidly(const Mat3& G, const Mat3& P);

/// Stage of a step before any force acts: gradients of the velocities, 0 for particles that are not free. No-slip solids are neighbours,
/// whose velocity continues the shear behind the surface.
///   G_i = turned_rigidly(sum_j w u_ij r_ij^T M^+),   M = sum_j w r_ij r_ij^T,   w = V |W'|/r
struct VelocityGradient {
    Real solid_factor = 1;  ///< factor on the volumes of boundary particles, see models/boundary/wall.h
    SolidGate gate = {};
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::velocity> u,
                    Write<field::velocity_gradient> G) const;
};

}  // namespace whorl

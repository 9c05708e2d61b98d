#pragma once
/// Term that makes an implicit strain second order in time (docs/physics.md 4).
///
/// A step computes the strain rates of the new velocities at the positions at its start. It then moves every particle along a straight
/// line. In a rigid rotation at the rate w these velocities have no strain rate at the positions in the middle of the move. At the
/// positions at the start they appear to shrink the body across the axis, at the rate dt w^2/2. T is this apparent strain rate, for a
/// motion that continues unchanged. With G the gradient of the velocities at the start of the step, the last step's deformation is A = (1 -
/// dt G)^-1. If the next step has the same deformation, its velocities have the gradient B/dt at the start of the step and H in the middle,
///   B = A - 1,   H = 2/dt B (2 + B)^-1,   T = sym(B/dt - H) = sym(B^2 (2 + B)^-1)/dt = dt/2 sym(G G) + O(dt^2).
/// So mu D:D becomes mu (D - T):(D - T). The stress 2 mu T acts through the transpose of the gradient, as the stress of D does. It is
/// symmetric, and its forces are opposite in each pair, so momentum and angular momentum are conserved.
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

/// G plus the columns that it lacks along directions that the neighbours do not resolve. The fluid is assumed to rotate rigidly with the
/// resolved directions. Otherwise a rotating line of particles would have no T along the line.
/// @param P Moment::resolved
Mat3 turned_rigidly(const Mat3& G, const Mat3& P);

/// Stage of a step before any force acts: gradients of the velocities, 0 for particles that are not free. No-slip solids are neighbours,
/// whose velocity continues the shear behind the surface.
///   G_i = turned_rigidly(sum_j w u_ij r_ij^T M^+, P),   M = sum_j w r_ij r_ij^T,   w = V |W'|/r
struct VelocityGradient {
    Real solid_factor = 1;  ///< factor on the volumes of boundary particles, see models/boundary/wall.h
    SolidGate gate = {};
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::velocity> u,
                    Write<field::velocity_gradient> G) const;
};

}  // namespace whorl

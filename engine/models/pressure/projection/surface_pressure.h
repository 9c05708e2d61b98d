#pragma once
/// Surface tension of the projection: a pressure on the surface, sigma times the curvature (docs/physics.md 10).
#include "engine/models/pressure/projection/projection_system.h"

namespace whorl {

/// p_s = sigma kappa near a free surface, for the rows of the pressure and for its gradient. sigma is the surface tension, kappa the
/// curvature, n the outward normal. Runs after ProjectionGeometry.
///
///   n = -S/|S|,  S = sum V grad W smoothed twice;   kappa = tr(P G P (P B P)^-1),  P = 1 - n n^T, across the normal,
///   B_i = sum_j w r r^T,  G_i = sum_j w (n_i - n_j) r^T,  w = V |W'|/r |S_j| d
///
/// The neighbours of i lie below the surface. On a sphere the curvature is larger below the surface, so with the neighbours' mean depth e
/// kappa becomes kappa/(1 + kappa e/(D - 1)). Particles on the surface are d/2 below it, where the pressure is higher by -d/2 dp/dn, with
/// dp/dn of the last step. Then p_s is smoothed by 2 M - M M, where M applies the mean over surface particles among the neighbours `means`
/// times. M alone would flatten resolved waves. At solids n has no component along the wall's normal: the contact angle is 90 degrees.
class SurfacePressure {
public:
    SurfacePressure(std::shared_ptr<ProjectionSystem> system, double tension)
        : system_(std::move(system)), tension_(static_cast<Real>(tension)) {}
    void operator()(const InteractionContext& context, Read<field::pressure_acceleration> before);

private:
    static constexpr int smoothings = 2, means = 3;
    template <class Kernel>
    void take_means(const Kernel& W, const InteractionContext& context);
    template <class Kernel>
    void find_normals(const Kernel& W, const InteractionContext& context);
    Real curvature(const InteractionContext& context, Index i, Span<const Real> slopes) const;

    std::shared_ptr<ProjectionSystem> system_;
    Real tension_;
    Column<Vec3> next_normal_;
    Column<Real> weight_, pressure_, next_pressure_;
};

}  // namespace whorl

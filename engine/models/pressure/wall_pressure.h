#pragma once
/// The pressure of solids on a fluid particle, shared by the pressure models.
#include "engine/particles/surroundings.h"

namespace whorl {

/// grad_i = sum_s V_s grad W_is        What a pressure of 1 at the solids does to fluid particle i, times -1 and its density.
template <class Kernel>
Vec3 wall_gradient(const Kernel& kernel, Index i, const Surroundings& around, Real volume_factor) {
    Vec3 gradient = Vec3::Zero();
    around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
        const Real slope = kernel.slope(distance);
        gradient += volume_factor * around.layer.volume[s] * slope * r;
    });
    return gradient;
}

/// The solids' part of the pressure force on fluid particle i is -(rho_0/rho_i^2) sum_s (p_i + p_s) V_s grad W_is, where a solid particle
/// mirrors p_i and adds the hydrostatic difference over the distance to it along its normal n_s, and never pulls:
///   p_i + p_s = max(0, 2 p_i - rho_0 (g.n_s)(r_is.n_s)).
/// Without the difference the pressure of the lowest layer is too high by rho g d: 1/N of the bottom pressure of N layers; and a ceiling
/// would push the topmost layer of a full box away, as if it weighed on it. The notes' form (Akinci et al. 2012) is p_i, half of it with a
/// volume 1.43 times as large.
template <class Kernel>
Vec3 wall_push(const Kernel& kernel, Index i, const Surroundings& around, Real volume_factor, Real p) {
    Vec3 push = Vec3::Zero();
    around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
        const Real slope = kernel.slope(distance);
        const Vec3& n = around.layer.normal[s];
        const Real both = 2 * p - around.step.rest_density * around.step.gravity.dot(n) * std::max(Real(0), r.dot(n));
        push += std::max(Real(0), both) * volume_factor * around.layer.volume[s] * slope * r;
    });
    return push;
}

}  // namespace whorl

#pragma once
/// The pressure of solids on a fluid particle, shared by the pressure models.
#include <limits>

#include "engine/geometry/solids.h"
#include "engine/particles/pairs.h"
#include "engine/particles/step.h"

namespace whorl {

/// The solids' part of the pressure force on fluid particle i is -(rho_0/rho_i^2)(2 p_i gradient + weight): a solid particle s mirrors p_i and
/// adds the hydrostatic difference over the distance to it along its normal n_s,
///   gradient = sum_s V_s grad W_is        weight = sum_s V_s rho_0 max(0, -g.n_s)(r_is.n_s) grad W_is.
/// Without the weight the pressure of the lowest layer is too high by rho g d: 1/N of the bottom pressure of N layers.
/// The notes' form (Akinci et al. 2012) is p_i gradient, half of it with a volume 1.43 times as large.
struct WallPush {
    Vec3 gradient = Vec3::Zero(), weight = Vec3::Zero();
};

template <class Kernel>
WallPush wall_push(const Kernel& kernel, Index i, const SolidPairs& pairs, const SolidParticles& solid, const StepContext& step, Real volume_factor) {
    WallPush push;
    pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
        const auto k = static_cast<std::size_t>(s);
        const Real slope = kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
        const Vec3 grad = volume_factor * solid.volume[k] * slope * r;
        push.gradient += grad;
        const Vec3& n = solid.normal[k];
        push.weight += step.rest_density * std::max(Real(0), -step.gravity.dot(n)) * std::max(Real(0), r.dot(n)) * grad;
    });
    return push;
}

}  // namespace whorl

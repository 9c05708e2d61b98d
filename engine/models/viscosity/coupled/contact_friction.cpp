#include "engine/models/viscosity/coupled/contact_friction.h"

#include <algorithm>

#include "engine/core/parallel.h"

namespace whorl {

void ContactFriction::set(Span<const Vec3> x, Span<const std::int16_t> role, Span<const Real> mu, const Solids& solids,
                          const StepContext& step) {
    coefficient.clear(), load.clear(), counted.clear();
    if (std::none_of(solids.all.begin(), solids.all.end(), [](const Solid& solid) { return solid.partial_slip(); })) return;
    coefficient.resize(x.size()), load.resize(x.size()), counted.assign(x.size(), 0);
    parallel_for(static_cast<Index>(x.size()), [&](Index i) {
        coefficient[i].setZero(), load[i].setZero();
        if (role[i] != 0) return;
        for (const Solid& solid : solids.all) {
            const Share share = share_of(solid, x[i], mu[i], step);
            coefficient[i] += share.coefficient;
            counted[i] = std::min(counted[i] + share.counted, Real(0.75));
            load[i] += share.coefficient * share.wall;
        }
    });
}

ContactFriction::Share ContactFriction::share_of(const Solid& solid, const Vec3& x, Real mu, const StepContext& step) {
    if (!solid.partial_slip()) return {};
    const Real d = step.spacing, height = solid.distance(x), share = std::clamp((Real(1.1) - height / d) / Real(0.2), Real(0), Real(1));
    if (share == 0) return {};
    const Vec3 n = solid.normal(x);
    const Real strength = step.dt * mu / step.rest_density * share / d / (std::max(height, d / 4) + static_cast<Real>(solid.slip_length));
    return {strength * (Mat3::Identity() - n * n.transpose()), share * std::clamp(height / d, Real(0), Real(1)), solid.velocity_at(x)};
}

}  // namespace whorl

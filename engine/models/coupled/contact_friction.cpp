#include "engine/models/coupled/contact_friction.h"

#include <algorithm>

#include "engine/core/parallel.h"

namespace whorl {

void ContactFriction::set(Span<const Vec3> x, Span<const std::int16_t> role, Span<const Real> mu, const Solids& solids,
                          const StepContext& step) {
    coefficient.clear(), load.clear(), counted.clear();
    if (std::none_of(solids.all.begin(), solids.all.end(), [](const Solid& solid) { return solid.partial_slip(); })) return;
    coefficient.resize(x.size()), load.resize(x.size()), counted.assign(x.size(), 0);
    const Real d = step.spacing;
    parallel_for(static_cast<Index>(x.size()), [&](Index i) {
        coefficient[i].setZero(), load[i].setZero();
        if (role[i] != 0) return;
        for (const Solid& solid : solids.all) {
            if (!solid.partial_slip()) continue;
            const Real height = solid.distance(x[i]), share = std::clamp((Real(1.1) - height / d) / Real(0.2), Real(0), Real(1));
            if (share == 0) continue;
            const Vec3 n = solid.normal(x[i]);
            const Real strength =
                step.dt * mu[i] / step.rest_density * share / d / (std::max(height, d / 4) + static_cast<Real>(solid.slip_length));
            const Mat3 own = strength * (Mat3::Identity() - n * n.transpose());
            coefficient[i] += own;
            counted[i] = std::min(counted[i] + share * std::clamp(height / d, Real(0), Real(1)), Real(0.75));
            load[i] += own * solid.velocity_at(x[i]);
        }
    });
}

}  // namespace whorl

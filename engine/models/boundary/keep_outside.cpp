#include "engine/models/boundary/keep_outside.h"

#include "engine/core/parallel.h"

namespace whorl {

void KeepOutside::operator()(const Solids& solids, const SolidPairs& pairs, const StepContext& step, Read<field::role> role,
                             Update<field::position> x, Update<field::velocity> u) const {
    if (solids.all.empty()) return;
    // The pairs are those before the move: a particle without solid neighbours was a support radius away.
    const Real far = step.support / 2;
    parallel_for(x.size(), [&](Index i) {
        if (role[i] != 0) return;
        if (pairs.count(i) == 0 && u[i].squaredNorm() * step.dt * step.dt < far * far) return;
        Real distance = 0;
        const int k = solids.nearest(x[i], distance);
        if (k < 0 || !(distance < 0)) return;
        const Solid& solid = solids.all[static_cast<std::size_t>(k)];
        const Vec3 n = solid.normal(x[i]);
        x[i] -= distance * n;
        const Real inward = (u[i] - solid.pose.velocity_at(x[i])).dot(n);
        if (inward < 0) u[i] -= inward * n;
    });
}

}  // namespace whorl

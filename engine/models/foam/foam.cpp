#include "engine/models/foam/foam.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Rises linearly from 0 at `low` to 1 at `high`.
Real ramp(Real value, Real low, Real high) { return std::clamp((value - low) / (high - low), Real(0), Real(1)); }

/// sum of 1 - r/R over a lattice, without its middle. @param reach R over the spacing
Real lattice_sum(Real reach, int dimensions) {
    const int n = static_cast<int>(std::ceil(reach)), deep = dimensions == 2 ? 0 : n;
    Real sum = -1;
    for (int i = -n; i <= n; ++i)
        for (int j = -n; j <= n; ++j)
            for (int k = -deep; k <= deep; ++k) sum += std::max(Real(0), 1 - std::sqrt(static_cast<Real>(i * i + j * j + k * k)) / reach);
    return sum;
}

/// Sums over a particle's neighbours, over the lattice's sum.
struct Company {
    Real amount = 0;         ///< 1 inside the fluid
    Real approach = 0;       ///< m/s
    Vec3 out = Vec3::Zero();  ///< m, towards where neighbours are missing
};

}  // namespace

void Foam::operator()(const InteractionContext& context, Read<field::velocity> u, Update<field::foam> foam,
                      Update<field::airborne> airborne) const {
    const StepContext& step = context.step;
    const Real R = step.support, over_R = 1 / R, over_sum = 1 / lattice_sum(R / step.spacing, step.dimensions());
    const auto company_of = [&](Index i) {
        Company c;
        const auto add = [&](const Pairs::Group& group, const auto& approach) {
            Real amount = 0, closing = 0, x = 0, y = 0, z = 0;
            for (Index l = 0; l < group.padded(); ++l) {
                const Real w = std::max(Real(0), 1 - group.distance[l] * over_R);
                amount += w, closing += w * approach(group, l);
                x += w * group.r[0][l], y += w * group.r[1][l], z += w * group.r[2][l];
            }
            c.amount += over_sum * amount, c.approach += over_sum * closing, c.out += over_sum * Vec3(x, y, z);
        };
        context.pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real other[3][Pairs::Group::most];
            group.gather(u.data(), other);
            add(group, [&](const Pairs::Group& g, Index l) {
                const Real a = u[i][0] - other[0][l], b = u[i][1] - other[1][l], d = u[i][2] - other[2][l];
                return std::sqrt(a * a + b * b + d * d) -
                       (a * g.r[0][l] + b * g.r[1][l] + d * g.r[2][l]) / std::max(g.distance[l], min_positive);
            });
        });
        context.solid_pairs.groups_of(i, [&](const Pairs::Group& group) { add(group, [](const Pairs::Group&, Index) { return Real(0); }); });
        return c;
    };
    parallel_for(foam.size(), [&](Index i) {
        const Company near = company_of(i);
        const Real speed = u[i].norm(), outwards = u[i].dot(near.out) / std::max(speed * near.out.norm(), min_positive);
        const Real trapped = ramp(near.approach, Real(0.15), Real(0.6)) * ramp(1 - near.amount, Real(0.05), Real(0.2));
        const Real crest = ramp(outwards, Real(0.5), Real(0.8)) * ramp(near.amount, Real(0.6), Real(0.4));
        const Real energy = ramp(speed * speed / 2, Real(0.05), Real(0.5));
        const bool spray = near.amount < alone && speed > spray_speed;
        const Real rate = energy * (trapped + crest) / grow + (spray ? 1 / burst : 0);
        // Exact for a constant rate, so that no step is too long.
        const Real all = rate + 1 / decay;
        foam[i] = rate / all + (foam[i] - rate / all) * std::exp(-all * step.dt);
        airborne[i] = spray ? airborne[i] + step.dt : airborne[i] * std::exp(-step.dt / landing);
    });
}

}  // namespace whorl

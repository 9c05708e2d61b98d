#include "engine/models/foam/foam.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Rises linearly from 0 at `low` to 1 at `high`.
Real ramp(Real value, Real low, Real high) { return std::clamp((value - low) / (high - low), Real(0), Real(1)); }

/// Sum of w = 1 - r/R over the neighbours on a lattice. @param reach R over the spacing
Real lattice_sum(Real reach, int dimensions) {
    const int n = static_cast<int>(std::ceil(reach)), deep = dimensions == 2 ? 0 : n;
    Real sum = -1;
    for (int i = -n; i <= n; ++i)
        for (int j = -n; j <= n; ++j)
            for (int k = -deep; k <= deep; ++k) sum += std::max(Real(0), 1 - std::sqrt(static_cast<Real>(i * i + j * j + k * k)) / reach);
    return sum;
}

/// Sums over a particle's neighbours, weighted by w and divided by the sum of w on a lattice.
struct Company {
    Real fluid = 0, solid = 0;  ///< sums of 1 over fluid and boundary particles; 1 in total inside the fluid
    Real approach = 0;          ///< sum of |u_ij| - u_ij.r_ij/r [m/s]
    Real foam = 0;
    Vec3 out = Vec3::Zero();  ///< sum of r_ij [m]; points out of the fluid at a surface
};

Company company_of(Index i, const InteractionContext& context, const Vec3* u, const Real* foam, Real over_sum) {
    const Real over_R = 1 / context.step.support;
    const Vec3 own = u[i];
    Company c;
    context.pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[3][Pairs::Group::most], other_foam[Pairs::Group::most];
        group.gather(u, other), group.gather(foam, other_foam);
        Real amount = 0, approach = 0, air = 0, x = 0, y = 0, z = 0;
        for (Index l = 0; l < group.padded(); ++l) {
            const Real w = std::max(Real(0), 1 - group.distance[l] * over_R);
            const Real a = own[0] - other[0][l], b = own[1] - other[1][l], d = own[2] - other[2][l];
            const Real parting = (a * group.r[0][l] + b * group.r[1][l] + d * group.r[2][l]) / std::max(group.distance[l], min_positive);
            amount += w, air += w * other_foam[l], approach += w * (std::sqrt(a * a + b * b + d * d) - parting);
            x += w * group.r[0][l], y += w * group.r[1][l], z += w * group.r[2][l];
        }
        c.fluid += over_sum * amount, c.foam += over_sum * air, c.approach += over_sum * approach, c.out += over_sum * Vec3(x, y, z);
    });
    context.solid_pairs.of(i, [&](Index, const Vec3& r, Real distance) {
        const Real w = over_sum * std::max(Real(0), 1 - distance * over_R);
        c.solid += w, c.out += w * r;
    });
    return c;
}

}  // namespace

void Foam::operator()(const InteractionContext& context, Read<field::velocity> u, Write<field::old_foam> old_foam, Update<field::foam> foam,
                      Update<field::airborne> airborne) const {
    const StepContext& step = context.step;
    const Real over_sum = 1 / lattice_sum(step.support / step.spacing, step.dimensions());
    parallel_for(foam.size(), [&](Index i) { old_foam[i] = foam[i]; });
    parallel_for(foam.size(), [&](Index i) {
        const Company near = company_of(i, context, u.data(), old_foam.data(), over_sum);
        const Real amount = near.fluid + near.solid, speed = u[i].norm();
        const Real outwards = u[i].dot(near.out) / std::max(speed * near.out.norm(), min_positive);
        const Real trapped = ramp(near.approach, Real(0.15), Real(0.55)) * ramp(amount, Real(0.95), Real(0.8));
        const Real crest = ramp(outwards, Real(0.5), Real(0.8)) * ramp(amount, Real(0.6), Real(0.4));
        const Real energy = ramp(speed * speed / 2, Real(0.05), Real(0.5));
        const bool spray = amount - light * near.foam < alone && speed > spray_speed;
        const Real gain = energy * (trapped + crest) / grow + (spray ? 1 / burst : 0), exchange = near.fluid > alone ? 1 / mixing : 0;
        // Exact solution for constant rates, so stable for any step.
        const Real rate = gain + 1 / decay + exchange, end = (gain + exchange * near.foam / std::max(near.fluid, alone)) / rate;
        foam[i] = end + (old_foam[i] - end) * std::exp(-rate * step.dt);
        airborne[i] = spray ? airborne[i] + step.dt : airborne[i] * std::exp(-step.dt / landing);
    });
}

}  // namespace whorl

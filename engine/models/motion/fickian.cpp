#include "engine/models/motion/fickian.h"

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/math/kernel.h"

namespace whorl {

void FickianShift::operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho, Read<field::velocity> u,
                              Write<field::shift> shift, Update<field::position> x) const {
    const StepContext& step = context.step;
    const Real farthest = step.spacing / 20;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        const Real over_first = 1 / W.value(step.spacing);
        parallel_for(x.size(), [&](Index i) {
            shift[i].setZero();
            const Real dense = std::clamp((rho[i] / step.rest_density - Real(0.9)) * 20, Real(0), Real(1));
            if (role[i] != 0 || dense == 0) return;
            const Vec3 own = u[i];
            Vec3 gradient = Vec3::Zero();
            Real fastest[most_lanes] = {};  // one per SIMD lane
            context.pairs.groups_of(i, [&](const Pairs::Group& group) {
                Real other[3][Pairs::Group::most], part[3] = {0, 0, 0}, apart[Pairs::Group::most];
                group.gather(u.data(), other);
                for (Index l = 0; l < group.padded(); ++l) {
                    const Real r = group.distance[l], q = W.value(r) * over_first, weight = (1 + Real(0.2) * q * q * q * q) * W.slope(r);
                    for (int c = 0; c < 3; ++c) part[c] += weight * group.r[c][l];
                    const Real ux = own[0] - other[0][l], uy = own[1] - other[1][l], uz = own[2] - other[2][l];
                    apart[l] = ux * ux + uy * uy + uz * uz;
                }
                gradient += step.volume * Vec3(part[0], part[1], part[2]);
                for (Index from = 0; from < group.padded(); from += most_lanes)
                    for (Index l = 0; l < most_lanes; ++l) fastest[l] = apart[from + l] > fastest[l] ? apart[from + l] : fastest[l];
            });
            const Real at_solids = solid_factor * gate.weight(W, i, context.solid_pairs, context.boundary.volume, solid_factor);
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                gradient += at_solids * context.boundary.volume[s] * W.slope(distance) * r;
            });
            const Real surrounded = std::clamp(3 - Real(2.5) * step.support * gradient.norm(), Real(0), Real(1));
            Vec3 move =
                -step.dt * std::sqrt(*std::max_element(fastest, fastest + most_lanes)) * step.support * dense * surrounded * gradient;
            const Real length = move.norm();
            if (length > farthest) move *= farthest / length;
            shift[i] = move;
        });
    });
    lift_nothing(step.gravity, shift.values);
    parallel_for(x.size(), [&](Index i) { x[i] += shift[i]; });
}

}  // namespace whorl

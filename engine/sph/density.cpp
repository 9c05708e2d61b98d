#include "engine/sph/density.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// sum_j W_ij
template <class Kernel>
Real sum_over_row(const Pairs& pairs, Index i, const Kernel& W) {
    Real sum = 0;
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real part = 0;
        for (Index l = 0; l < group.padded(); ++l) part += W.value(group.distance[l]);
        sum += part;
    });
    return sum;
}

}  // namespace

void sum_density(const Surroundings& around, Real solid_factor, SolidGate gate, Span<Real> density) {
    const StepContext& step = around.step;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        const Real m = step.mass, own = m * W.value(0);
        const bool any_solids = around.solid_pairs.size() == around.pairs.size() && !around.solid_pairs.other.empty();
        parallel_for(around.pairs.size(), [&](Index i) {
            const Real sum = sum_over_row(around.pairs, i, W);
            Real wall = 0;
            if (any_solids)
                around.solid_pairs.of(i, [&](Index s, const Vec3&, Real distance) { wall += around.layer.volume[s] * W.value(distance); });
            if (wall > 0) wall *= gate.weight(W, i, around.solid_pairs, around.layer.volume, solid_factor);
            density[i] = own + m * sum + step.rest_density * solid_factor * wall;
        });
    });
}

}  // namespace whorl

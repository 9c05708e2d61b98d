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

void sum_density(const InteractionContext& context, Real solid_factor, SolidGate gate, Span<Real> density) {
    const StepContext& step = context.step;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        const Real m = step.mass, own = m * W.value(0);
        const bool any_solids = context.solid_pairs.size() == context.pairs.size() && !context.solid_pairs.other.empty();
        parallel_for(context.pairs.size(), [&](Index i) {
            const Real sum = sum_over_row(context.pairs, i, W);
            Real wall = 0;
            if (any_solids)
                context.solid_pairs.of(
                    i, [&](Index s, const Vec3&, Real distance) { wall += context.boundary.volume[s] * W.value(distance); });
            if (wall > 0) wall *= gate.weight(W, i, context.solid_pairs, context.boundary.volume, solid_factor);
            density[i] = own + m * sum + step.rest_density * solid_factor * wall;
        });
    });
}

}  // namespace whorl

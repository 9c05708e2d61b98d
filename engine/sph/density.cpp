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

void sum_density(const FluidPairs& fluid, const SolidPairs& solids, Span<const Real> solid_volume, Real solid_factor, SolidGate gate,
                 const StepContext& step, Span<Real> density) {
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        const Real m = step.mass, own = m * W.value(0);
        const bool any_solids = solids.size() == fluid.size() && !solids.other.empty();
        parallel_for(fluid.size(), [&](Index i) {
            const Real sum = sum_over_row(fluid, i, W);
            Real wall = 0;
            if (any_solids) solids.of(i, [&](Index s, const Vec3&, Real distance) { wall += solid_volume[s] * W.value(distance); });
            if (wall > 0) wall *= gate.weight(W, i, solids, solid_volume, solid_factor);
            density[i] = own + m * sum + step.rest_density * solid_factor * wall;
        });
    });
}

void sum_number_density(const Pairs& pairs, const StepContext& step, Span<Real> number_density) {
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(pairs.size(), [&](Index i) { number_density[i] = W.value(0) + sum_over_row(pairs, i, W); });
    });
}

}  // namespace whorl

#include "engine/sph/density.h"

#include "engine/core/parallel.h"

namespace whorl {

void sum_density(const FluidPairs& fluid, const SolidPairs& solids, Span<const Real> solid_volume, Real solid_factor, const StepContext& step,
                 Span<Real> density) {
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        const Real m = step.mass, own = m * W.value(0);
        const bool any_solids = solids.size() == fluid.size() && !solids.other.empty();
        parallel_for(fluid.size(), [&](Index i) {
            Real sum = 0;
            fluid.of(i, [&](Index, const Vec3&, Real distance) { sum += W.value(distance); });
            Real wall = 0;
            if (any_solids)
                solids.of(i, [&](Index s, const Vec3&, Real distance) { wall += solid_volume[static_cast<std::size_t>(s)] * W.value(distance); });
            density[static_cast<std::size_t>(i)] = own + m * sum + step.rest_density * solid_factor * wall;
        });
    });
}

void sum_number_density(const Pairs& pairs, const StepContext& step, Span<Real> number_density) {
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(pairs.size(), [&](Index i) {
            Real sum = W.value(0);
            pairs.of(i, [&](Index, const Vec3&, Real distance) { sum += W.value(distance); });
            number_density[static_cast<std::size_t>(i)] = sum;
        });
    });
}

}  // namespace whorl

#pragma once
/// Density by the kernel sum, solids included.
#include "engine/core/parallel.h"
#include "engine/geometry/solids.h"
#include "engine/particles/pairs.h"
#include "engine/particles/step.h"

namespace whorl {

/// rho_i = m W(0) + sum_j m W_ij + rho_0 sum_s f V_s W_is
struct Density {
    Real solid_factor = 1;  ///< f on the solids' volumes, see models/boundary/wall.h

    void operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const SolidParticles& solid, const StepContext& step,
                    Write<field::density> rho) const {
        with_kernel(step.kernel, step.support, [&](const auto& kernel) {
            parallel_for(rho.size(), [&](Index i) {
                Real fluid = kernel.value(0);
                pairs.of(i, [&](Index, const Vec3&, Real r) { fluid += kernel.value(r); });
                Real wall = 0;
                if (solid.size() > 0)
                    solid_pairs.of(i, [&](Index s, const Vec3&, Real r) { wall += solid.volume[static_cast<std::size_t>(s)] * kernel.value(r); });
                rho[i] = step.mass * fluid + step.rest_density * solid_factor * wall;
            });
        });
    }
};

}  // namespace whorl

#include "engine/models/viscosity/flow_law.h"

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/strain/curvature.h"

namespace whorl {

double FlowLaw::apparent_viscosity(double K, double gamma) const {
    const double own = yield_stress > 0 && K > 0 ? std::pow(yield_stress / K, 1 / index) / contrast : rigid_rate;
    const double g0 = std::min(rigid_rate, own), x = gamma / g0;
    const double plastic = yield_stress / g0 * (x > 1e-6 ? -std::expm1(-x) / x : 1);
    return plastic + (index == 1 ? K : K * std::pow(std::max(gamma, g0), index - 1));
}

void FlowLaw::begin(Span<const Real> K, Span<const Mat3> G, Real dt, int dimensions, Span<Real> apparent) const {
    parallel_for(static_cast<Index>(apparent.size()), [&](Index i) {
        if (apparent[i] > 0) return;
        const Mat3 D = (G[i] + G[i].transpose()) / 2 - curvature_strain(G[i], dt);
        apparent[i] = static_cast<Real>(apparent_viscosity(static_cast<double>(K[i]), static_cast<double>(shear_rate(D, dimensions))));
    });
}

double FlowLaw::update(Span<const Real> K, Span<const Real> gamma, Span<Real> apparent) const {
    struct Power {
        double change = 0, all = 0;
        void operator+=(const Power& o) { change += o.change, all += o.all; }
    };
    const Power sum = parallel_sum(static_cast<Index>(apparent.size()), Power{}, [&](Index i) {
        const double rate = gamma[i], before = apparent[i], mu = apparent_viscosity(K[i], rate);
        apparent[i] = static_cast<Real>(mu);
        return before > 0 ? Power{rate * rate * std::abs(mu - before), rate * rate * before} : Power{};
    });
    return sum.all > 0 ? sum.change / sum.all : 0;
}

}  // namespace whorl

#include "engine/models/viscosity/flow_law.h"

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/strain/curvature.h"

namespace whorl {

double FlowLaw::rate_of_rigid(double K) const {
    return yield_stress > 0 && K > 0 ? std::min(rigid_rate, std::pow(yield_stress / K, 1 / index) / contrast) : rigid_rate;
}

double FlowLaw::apparent_viscosity(double K, double gamma) const {
    const double g0 = rate_of_rigid(K), x = gamma / g0;
    const double plastic = yield_stress / g0 * (x > 1e-6 ? -std::expm1(-x) / x : 1);
    return plastic + (index == 1 ? K : K * std::pow(std::max(gamma, g0), index - 1));
}

double FlowLaw::tangent_viscosity(double K, double gamma) const {
    const double g0 = rate_of_rigid(K);
    return yield_stress / g0 * std::exp(-gamma / g0) + (index == 1 ? K : index * K * std::pow(std::max(gamma, g0), index - 1));
}

FlowViscosity::FlowViscosity(const FlowLaw& chosen, Read<field::viscosity> consistency, Span<const Mat3> before, const StepContext& step,
                             Update<field::shear_rate> rate, Write<field::apparent_viscosity> viscosity)
    : law(chosen), K(consistency), gamma(rate.values), mu(viscosity.values), soft(K.values.size()), solved(K.values.size()) {
    parallel_for(K.size(), [&](Index i) {
        if (gamma[i] > 0) return;
        const Mat3 D = (before[i] + before[i].transpose()) / 2 - curvature_strain(before[i], step.dt);
        gamma[i] = shear_rate(D, step.dimensions());
    });
    update();
}

bool FlowViscosity::again(int solves) {
    struct Power {
        double change = 0, all = 0;
        void operator+=(const Power& o) { change += o.change, all += o.all; }
    };
    const Power sum = parallel_sum(K.size(), Power{}, [&](Index i) {
        const double rate = gamma[i] = solved[i], used = mu[i];
        return Power{rate * rate * std::abs(law.apparent_viscosity(static_cast<double>(K[i]), rate) - used), rate * rate * used};
    });
    return sum.change > law.tolerance * sum.all && solves < law.most_solves;
}

void FlowViscosity::update() {
    parallel_for(K.size(), [&](Index i) {
        const double k = K[i], rate = gamma[i];
        mu[i] = static_cast<Real>(law.apparent_viscosity(k, rate));
        soft[i] = static_cast<Real>(law.penalised * law.tangent_viscosity(k, rate));
    });
}

}  // namespace whorl

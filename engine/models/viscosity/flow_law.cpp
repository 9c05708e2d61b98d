#include "engine/models/viscosity/flow_law.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/models/viscosity/strain/curvature.h"

namespace whorl {

double FlowLaw::rate_of_rigid(double tau_y, double K) const {
    return tau_y > 0 && K > 0 ? std::min(rigid_rate, std::pow(tau_y / K, 1 / index) / contrast) : rigid_rate;
}

double FlowLaw::apparent_viscosity(double tau_y, double K, double gamma) const {
    const double g0 = rate_of_rigid(tau_y, K), x = gamma / g0;
    const double plastic = tau_y / g0 * (x > 1e-6 ? -std::expm1(-x) / x : 1);
    return plastic + (index == 1 ? K : K * std::pow(std::max(gamma, g0), index - 1));
}

double FlowLaw::tangent_viscosity(double tau_y, double K, double gamma) const {
    const double g0 = rate_of_rigid(tau_y, K);
    return tau_y / g0 * std::exp(-gamma / g0) + (index == 1 ? K : index * K * std::pow(std::max(gamma, g0), index - 1));
}

// Sequential, because expressions are not thread-safe.
void MeltingYieldStress::operator()(const StepContext& step, StepReport& report, Read<field::position> x,
                                    Read<field::temperature> T) const {
    resize_tightly(*tau_y, x.values.size());
    for (Index i = 0; i < x.size(); ++i) {
        const double hot = static_cast<double>(T[i]), value = of_temperature(0, Vec3d::Zero(), hot);
        if (!is_viscosity(value) && !report.diverged)
            report.diverged = Divergence{"melting", "yield stress", step.time, x[i].cast<double>(),
                                         fmt::format("fluid.yield_stress is {:.4g} Pa at {:.4g} K", value, hot)};
        (*tau_y)[i] = static_cast<Real>(value);
    }
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
        return Power{rate * rate * std::abs(law.apparent_viscosity(yield_stress(i), K[i], rate) - used), rate * rate * used};
    });
    return sum.change > law.tolerance * sum.all && solves < law.most_solves;
}

void FlowViscosity::update() {
    parallel_for(K.size(), [&](Index i) {
        const double k = K[i], rate = gamma[i];
        mu[i] = static_cast<Real>(law.apparent_viscosity(yield_stress(i), k, rate));
        soft[i] = static_cast<Real>(law.penalised * law.tangent_viscosity(yield_stress(i), k, rate));
    });
}

}  // namespace whorl

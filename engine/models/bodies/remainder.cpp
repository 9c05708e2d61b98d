#include <numeric>

#include "engine/models/bodies/reaction.h"

namespace whorl {

Remainder::Remainder(const Solids& solids, Push kind) : kind_(kind) {
    for (const Solid& solid : solids.all) before_.push_back(solid.ledger[kind]);
}

Wrench Remainder::received(const Solids& solids) const {
    Wrench sum;
    for (std::size_t k = 0; k < before_.size(); ++k) {
        const Wrench one = received(solids, k);
        sum += one + Wrench{Vec3d::Zero(), solids.all[k].centre().cross(one.force)};
    }
    return sum;
}

void Remainder::share(Solids& solids, const StepContext& step, const Wrench& rest, const std::vector<std::size_t>& exact) const {
    std::vector<double> weight(before_.size(), 0);
    for (std::size_t k = 0; k < weight.size(); ++k)
        if (!solids.all[k].body) weight[k] = received(solids, k).force.norm();
    std::vector<double> others = weight;
    for (const std::size_t k : exact) others[k] = 0;
    if (std::accumulate(others.begin(), others.end(), 0.0) > 0) weight = others;
    const double weights = std::accumulate(weight.begin(), weight.end(), 0.0);
    for (std::size_t k = 0; k < weight.size(); ++k) {
        if (!(weight[k] > 0)) continue;
        Wrench part{rest.force, rest.torque - solids.all[k].centre().cross(rest.force)};
        if (step.domain.any_periodic()) part.torque.setZero();
        solids.all[k].receive(kind_, weight[k] / weights * part);
    }
}

}  // namespace whorl

#include "engine/models/bodies/remainder.h"

#include <numeric>

namespace whorl {

Remainder::Remainder(const Solids& solids, Push kind) : kind_(kind) {
    if (!solids.any_probed()) return;
    for (const Solid& solid : solids.all) before_.push_back(solid.ledger[kind]);
}

void Remainder::share(const Surroundings& around, const std::vector<std::size_t>& exact, const Wrench& gained) const {
    std::vector<Solid>& all = around.solids.all;
    Wrench rest = -static_cast<double>(around.step.mass) * gained;
    std::vector<double> weight(all.size(), 0);
    for (std::size_t k = 0; k < all.size(); ++k) {
        const Wrench received = all[k].ledger[kind_] + -1 * before_[k];
        rest += {-received.force, -received.torque - all[k].centre().cross(received.force)};
        if (!all[k].body) weight[k] = received.force.norm();
    }
    std::vector<double> others = weight;
    for (const std::size_t k : exact) others[k] = 0;
    if (std::accumulate(others.begin(), others.end(), 0.0) > 0) weight = others;
    const double weights = std::accumulate(weight.begin(), weight.end(), 0.0);
    if (!(weights > 0)) return;
    for (std::size_t k = 0; k < all.size(); ++k) {
        Wrench part = rest;
        part.torque -= all[k].centre().cross(rest.force);
        if (around.step.domain.any_periodic()) part.torque.setZero();
        if (weight[k] > 0) all[k].receive(kind_, weight[k] / weights * part);
    }
}

}  // namespace whorl

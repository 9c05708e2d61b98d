#include "engine/models/bodies/reaction.h"

#include <numeric>

namespace whorl {
namespace {

template <class Wanted>
std::vector<Index> particles_near(const InteractionContext& context, const Wanted& wanted) {
    std::vector<Index> near;
    for (Index i = 0; i < context.solid_pairs.size(); ++i) {
        bool touches = false;
        for (std::size_t k = context.solid_pairs.first[i]; k < context.solid_pairs.first[i + 1] && !touches; ++k)
            touches = wanted(static_cast<std::size_t>(context.boundary.solid[context.solid_pairs.other[k]]));
        if (touches) near.push_back(i);
    }
    return near;
}

}  // namespace

std::vector<Index> particles_at(const InteractionContext& context, std::size_t k) {
    return particles_near(context, [k](std::size_t solid) { return solid == k; });
}

std::vector<Index> particles_at_bodies(const InteractionContext& context) {
    return particles_near(context, [&](std::size_t solid) { return context.solids.all[solid].body.has_value(); });
}

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

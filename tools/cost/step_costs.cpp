#include "tools/cost/step_costs.h"

#include <algorithm>

namespace whorl {

StepCosts mean(const StepCosts& a, const StepCosts& b) {
    StepCosts half;
    for (const StepCosts* costs : {&a, &b})
        for (const auto& [name, cost] : *costs) half[name].particle += 0.5 * cost.particle, half[name].waits += 0.5 * cost.waits;
    return half;
}

void StepMeter::begin(const Simulation& simulation) {
    with_all_ = !with_all_ && threads() > 1;
    if (!with_all_) alone_.emplace();
    times_ = simulation.times(), totals_ = simulation.totals();
}

void StepMeter::end(const Simulation& simulation) {
    alone_.reset();
    Sum& sum = with_all_ ? all_ : one_;
    for (const auto& [name, t] : simulation.times()) {
        const auto before = times_.find(name);
        sum.cpu[name] += t.cpu - (before == times_.end() ? 0 : before->second.cpu);
    }
    sum.particle_steps += simulation.totals().particle_steps - totals_.particle_steps;
    sum.steps += simulation.totals().steps - totals_.steps;
}

StepCosts StepMeter::costs() const {
    StepCosts costs;
    const Sum& own = one_.particle_steps > 0 ? one_ : all_;
    for (const auto& [name, cpu] : own.cpu) costs[name].particle = cpu / std::max(1.0, own.particle_steps);
    if (one_.particle_steps > 0 && all_.particle_steps > 0)
        for (const auto& [name, cpu] : all_.cpu)
            costs[name].waits =
                std::max(0.0, cpu - costs[name].particle * all_.particle_steps) / static_cast<double>(std::max(1L, all_.steps));
    return costs;
}

}  // namespace whorl

#include "engine/models/viscosity/full_viscosity.h"

namespace whorl {

void FullViscosity::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                               Read<field::viscosity> mu, Read<field::velocity_gradient> before, Update<field::velocity> u,
                               Update<field::viscous_acceleration> last, Update<field::viscous_aggregate> aggregate) {
    operator_.set_up(options_, context, role, mu, {}, before.values);
    set_up_coarse(context.pairs, context.step, role, x, aggregate.values);
    solve_implicit(operator_, options_.limits, {context, report, role, x, u, last});
    operator_.release();
}

void YieldingViscosity::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                                   Read<field::viscosity> K, Read<field::velocity_gradient> before, Update<field::velocity> u,
                                   Update<field::viscous_acceleration> last, Update<field::viscous_aggregate> aggregate,
                                   Update<field::shear_rate> gamma, Write<field::apparent_viscosity> mu) {
    const ImplicitStep s{context, report, role, x, u, last};
    FlowViscosity flow(law_, K, before.values, context.step, gamma, mu);
    operator_.limit_penalty(flow.soft);
    SolveLimits loose = options_.limits;
    loose.tolerance *= law_.looseness;
    for (int solves = 1;; ++solves) {
        operator_.set_up(options_, context, role, {mu.values}, {}, before.values);
        set_up_coarse(context.pairs, context.step, role, x, aggregate.values, true);
        operator_.shear_rates(find_solution(operator_, loose, s).u, flow.solved);
        if (!flow.again(solves)) break;
        flow.update();
    }
    solve_implicit(operator_, options_.limits, s);
    operator_.release();
    operator_.limit_penalty({});
}

void FullViscosity::set_up_coarse(const FluidPairs& pairs, const StepContext& step, Read<field::role> role, Read<field::position> x,
                                  Span<std::int32_t> aggregate, bool changed) {
    operator_.use_coarse(nullptr);
    const double d2 = static_cast<double>(step.spacing) * step.spacing;
    const bool automatic = options_.preconditioner == ViscousPreconditioner::automatic;
    if (automatic ? operator_.largest_spread() < options_.coarse_above * d2 : options_.preconditioner != ViscousPreconditioner::two_level) {
        coarse_.clear();
        std::fill(aggregate.begin(), aggregate.end(), 0);
        return;
    }
    const bool fresh = coarse_.due(step.at_frame_time, options_.refresh_every);
    const int groups =
        fresh ? form_aggregates(pairs, x.values, role.values, step.domain, step.support, options_.aggregate, aggregate) : coarse_.groups();
    coarse_.place(x.values, role.values, aggregate, groups, step.domain, step.spacing);
    if ((fresh || changed) && groups > 0) coarse_.factor(operator_.coarse_matrix(coarse_.motions()));
    if (coarse_.groups() > 0) operator_.use_coarse(&coarse_);
}

}  // namespace whorl

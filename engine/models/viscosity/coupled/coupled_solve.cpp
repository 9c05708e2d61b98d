#include "engine/models/viscosity/coupled/coupled_solve.h"

#include <algorithm>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/viscosity/coupled/coupled_step.h"

namespace whorl {

void CoupledNeighbourhood::operator()(Read<field::position> x, Read<field::role> role, Write<field::density> density,
                                      Update<field::held> held, Update<field::contact_normal> slip, const Solids& solids,
                                      const StepContext& step) const {
    CoupledSystem& s = *system;
    s.rows.build(x.values, role.values, step.domain, step.spacing, s.options, {solids, step.dt, held.values, slip.values});
    parallel_for(x.size(), [&](Index i) { density[i] = step.rest_density * s.rows.neighbourhood[i].density; });
}

void CoupledGradient::operator()(Read<field::velocity> u, Write<field::velocity_gradient> G, const Solids& solids,
                                 const StepContext& step) const {
    CoupledRows& rows = system->rows;
    const bool turns =
        std::any_of(solids.all.begin(), solids.all.end(), [](const Solid& s) { return s.pose.angular_velocity != Vec3::Zero(); });
    const auto set_walls = [&](Real dt) {
        if (!turns) return;  // the velocity does not depend on the sign of dt
        for (RowBlock& block : rows.blocks)
            for (WallPoint& wall : block.walls) wall.velocity = velocity_over(solids.all[wall.solid], wall.position, dt);
    };
    set_walls(-step.dt);  // mean over the last step, like the velocities of the particles
    velocity_gradients(rows, step.spacing, u.values, G.values);
    set_walls(step.dt);
    parallel_for(u.size(), [&](Index i) {
        if (rows.neighbourhood[i].unresolved > 0) G[i] = turned_rigidly(G[i], rows.resolved(i));
    });
}

void CoupledStep::set_up_form() {
    system.friction.set(system.rows, mu.values, step);
    form.set(system.rows, mu.values, dt, step.rest_density, d, options);
    form.set_friction(system.friction.coefficient);
    form.set_bodies(bodies.inertia);
}

void CoupledStep::find_unknowns() {
    for (Index i = 0; i < n; ++i) free_particles += role[i] == 0;
    nothing_held = free_particles == n && system.rows.walls == 0;
}

/// Sets the velocities of nozzles and solids.
void CoupledStep::set_known_velocities() {
    known.resize(entries, Vec3::Zero()), solved.resize(entries), load.resize(entries), work.resize(entries);
    parallel_for(n, [&](Index i) {
        known[i] = Vec3::Zero();
        if (role[i] > 0) u[i] = solids.all[role[i] - 1].velocity_at(x[i]);
        if (role[i] != 0) known[i] = u[i];
    });
}

void CoupledStep::prepare() {
    entries = static_cast<std::size_t>(n) + bodies.begin(context);
    set_up_form();
    find_unknowns();
    set_known_velocities();
    set_curvature();
    set_divergence();
}

/// @param changed the viscosities differ from those of the last solve
void CoupledStep::set_up_preconditioner(bool changed) {
    TwoLevel& M = system.preconditioner;
    const bool coarse = options.diagonal && free_particles >= options.fewest_for_coarse;
    if (!coarse) M.clear();
    else if (M.due(step.at_frame_time, options.refresh_every))
        M.refresh(form, x.values, role.values, options, step.domain, d, aggregate.values), changed = false;
    M.set(form, x.values, role.values, step.domain, d, aggregate.values);
    if (changed) M.factor(form);
    if (!options.diagonal) M.be_identity();
}

/// Errors of slow motions persist from step to step and add up. So the tolerance applies to steps in which the fastest fluid moves by
/// 0.4 d, and is reduced in proportion in shorter steps. The factor is at least 0.03, because in slow fluid errors decay.
SolveLimits CoupledStep::limits() const {
    const double share = std::clamp(dt * fastest / (0.4 * d), 0.03, 1.0);
    return {looseness * share * options.limits.tolerance, options.limits.max_iterations};
}

/// Solves by conjugate gradients, starting from the last velocity plus 0.9 times its last change. @param again start from `solved`
SolveReport CoupledStep::solve(double reference, bool again) {
    const auto A = [this](Span<const Vec3> v, Span<Vec3> y) { return multiply(v, y); };
    const auto M = [this](Span<const Vec3> r, Span<Vec3> z) { return precondition(r, z); };
    const auto all = static_cast<Index>(entries);
    if (!again) {
        parallel_for(n, [&](Index i) { solved[i] = unknowns.part(i, u[i] + Real(0.9) * change[i]); });
        bodies.guess(dt * step.gravity, Span<Vec3>(solved).subspan(static_cast<std::size_t>(n)));
    }
    if (!(reference > 0)) return conjugate_gradients<Vec3>(A, M, load, solved, limits(), ResidualNorm::preconditioned);
    multiply(solved, work);
    parallel_for(all, [&](Index i) { load[i] -= work[i]; });  // the residual
    if (preconditioned_norm(load) > reference) {
        descend_along_last_change();
        M(load, work);
    }
    const SolveReport report = conjugate_gradients_from<Vec3>(A, M, load, solved, limits(), ResidualNorm::preconditioned, reference, work);
    if (!system.rows.any_slip) return report;
    // Removes the momentum of the residual. Otherwise the motion of sliding fluid as a whole would be too small by the tolerance.
    Column<Vec3> rest(entries, Vec3::Zero());
    parallel_for(n, [&](Index i) { solved[i] += rest[i] = unknowns.part(i, system.preconditioner.coarse(i)); });
    if (!writes_ledgers()) return report;
    multiply(rest, work);
    parallel_for(all, [&](Index i) { load[i] -= work[i]; });
    return report;
}

/// Solves again if bodies in contact cannot move as solved: with the velocities after contact, and with the motions that contact leaves
/// free.
SolveReport CoupledStep::solve_with_contact(double reference) {
    const auto first_body = static_cast<std::size_t>(n);
    Column<Vec3> moved(entries, Vec3::Zero());
    SolveReport report;
    report.converged = true;
    if (!bodies.touch(Span<const Vec3>(solved).subspan(first_body), Span<Vec3>(moved).subspan(first_body))) return report;
    form.apply(moved, work, [this](Index i, const Vec3& of_i) { return unknowns.part(i, of_i); });
    parallel_for(static_cast<Index>(entries), [&](Index i) { solved[i] += moved[i], load[i] -= work[i]; });
    bodies.free_part_of_forces(Span<Vec3>(load).subspan(first_body));
    if (!(reference > 0)) return report;
    return conjugate_gradients_from<Vec3>([this](Span<const Vec3> v, Span<Vec3> y) { return multiply(v, y); },
                                          [this](Span<const Vec3> r, Span<Vec3> z) { return precondition(r, z); }, load, solved, limits(),
                                          ResidualNorm::preconditioned, reference);
}

void CoupledStep::find_velocity(StepReport& report, bool again) {
    bodies.release();
    set_pressure();
    balance();
    const double reference = set_load();
    report.solves.push_back({SolveKind::coupled, solve(reference, again)});
    if (!bodies.any()) return;
    const SolveReport with_contact = solve_with_contact(reference);
    if (bodies.in_contact()) report.solves.push_back({SolveKind::coupled, with_contact});
}

/// Minimises the energy of the step along solved + far way, and updates the residual.
void CoupledStep::descend(Span<const Vec3> way) {
    Column<Vec3> bent(entries);
    const double stiffness = multiply(way, bent);
    if (!(stiffness > 0) || !std::isfinite(stiffness)) return;
    const Real far = static_cast<Real>(dot<Vec3>(way, load) / stiffness);
    parallel_for(static_cast<Index>(entries), [&](Index i) {
        solved[i] += far * way[i];
        load[i] -= far * bent[i];
    });
}

/// Replaces a bad initial guess (after an abrupt change of velocity or a landing): descends along the last step's change of velocity.
void CoupledStep::descend_along_last_change() {
    Column<Vec3> way(change.values.begin(), change.values.end());
    way.resize(entries, Vec3::Zero());
    unknowns.restrict_to(way);
    descend(way);
}

/// If no solid or nozzle acts: minimises E along the solution u without its rigid motion. Then u.(A u - b) = 0, so without loads |u| is
/// at most that of the velocities before, even if the solve is unfinished.
void CoupledStep::lose_energy() {
    if (!nothing_held) return;
    std::copy(solved.begin(), solved.end(), work.begin());
    RigidMotions(x.values, !step.domain.any_periodic()).remove(work);
    std::fill(work.begin() + n, work.end(), Vec3::Zero());  // no fluid touches a body
    descend(work);
}

/// Sets the gradient of the solution; leaves the solution in `work`.
void CoupledStep::find_gradient() {
    parallel_for(static_cast<Index>(entries), [&](Index i) { work[i] = known[i] + solved[i]; });
    form.gradient(work, G.values);
}

/// Sets gamma of the solution. @param gamma sqrt(2 D:D) of the deviator of D - T [1/s]
void CoupledStep::find_shear_rates(Span<Real> gamma) {
    find_gradient();
    parallel_for(n, [&](Index i) {
        const Mat3 in = system.rows.neighbourhood[i].unresolved > 0 ? Mat3(system.rows.resolved(i) * G[i]) : G[i];
        gamma[i] = shear_rate((in + in.transpose()) / 2 - curvature[i], system.rows.dimensions());
    });
}

/// If no solid or nozzle acts, all forces are internal: removes the momentum error of the unfinished solve as a rigid motion.
void CoupledStep::keep_momentum() {
    if (!nothing_held) return;
    parallel_for(n, [&](Index i) { work[i] = loaded(i, u[i]) - solved[i]; });
    RigidMotions(x.values, !step.domain.any_periodic()).add(work, solved);
}

/// Stores the new velocity, its gradient, and the new multiplier p - lambda (tr D - s). The multiplier has both signs: p < 0 holds a
/// stretched thread together and makes it thin. The multiplier is reduced by a fraction per step. Otherwise it would grow without end
/// in a closed vessel with too much fluid. The fraction is smaller for the part from 0 to the weight of the fluid, because fluid at
/// rest sinks with tr D = fraction times p/lambda.
void CoupledStep::take_over() {
    const auto depth = [&](Index i) { return static_cast<double>(step.gravity.dot(x[i])); };
    const double infinity = std::numeric_limits<double>::infinity();
    const double weight =
        step.rest_density * (parallel_max(n, -infinity, depth) + parallel_max(n, -infinity, [&](Index i) { return -depth(i); }));
    parallel_for(n, [&](Index i) {
        const Vec3& solution = work[i];
        change[i] = solution - u[i];
        u[i] = solution;
        const Real lambda = form.coefficients(i).bulk * step.rest_density * d * d / (dt * system.rows.neighbourhood[i].volume);
        p[i] -= lambda * (form.divergence(i, G[i]) - divergence[i]);
        const Real kept = std::clamp(p[i], Real(0), static_cast<Real>(weight));
        p[i] = static_cast<Real>(options.weight_memory) * kept + static_cast<Real>(options.memory) * (p[i] - kept);
    });
}

/// Gives the bodies their velocities, and the points on their surfaces too.
void CoupledStep::move_bodies() {
    if (!bodies.any()) return;
    const Span<const Vec3> moving = Span<const Vec3>(work).subspan(static_cast<std::size_t>(n));
    bodies.take_over(moving, solids);
    for (RowBlock& block : system.rows.blocks)
        for (WallPoint& wall : block.walls)
            if (wall.body >= 0) wall.velocity = wall.carried_by(moving);
}

void CoupledStep::finish(StepReport& report) {
    keep_momentum();
    keep_volume(report.solves.back().report);
    take_over();
    move_bodies();
    write_ledgers();
    count_pushes(report);
    release_slipping();
}

void CoupledSolve::operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> mu, Update<field::velocity> u,
                              Update<field::pressure> p, Update<field::velocity_change> change, Update<field::velocity_gradient> G,
                              Update<field::aggregate> aggregate, Update<field::contact_normal> slip, const InteractionContext& context,
                              StepReport& report) const {
    if (x.size() == 0) return;
    CoupledStep now{*system, x, role, mu, u, p, change, G, aggregate, slip, context};
    now.prepare();
    now.set_up_preconditioner(false);
    now.find_velocity(report);
    now.let_go();
    now.finish(report);
}

void CoupledYieldingSolve::operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> K,
                                      Update<field::shear_rate> gamma, Write<field::apparent_viscosity> mu, Update<field::velocity> u,
                                      Update<field::pressure> p, Update<field::velocity_change> change, Update<field::velocity_gradient> G,
                                      Update<field::aggregate> aggregate, Update<field::contact_normal> slip,
                                      const InteractionContext& context, StepReport& report) const {
    if (x.size() == 0) return;
    FlowViscosity flow(law, K, G.values, context.step, gamma, mu);
    system->form.limit_penalties(flow.soft);
    CoupledStep now{*system, x, role, {mu.values}, u, p, change, G, aggregate, slip, context, gamma.values};
    now.prepare();
    now.looseness = law.looseness;
    for (int solves = 1;; ++solves) {
        now.set_up_preconditioner(solves > 1);
        now.find_velocity(report, solves > 1);
        now.find_shear_rates(flow.solved);
        if (!flow.again(solves)) break;
        flow.update();
        now.set_up_form();
    }
    now.looseness = 1;
    now.find_velocity(report, true);
    now.lose_energy();
    now.finish(report);
    system->form.limit_penalties({});
}

}  // namespace whorl

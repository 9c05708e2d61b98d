#include "engine/simulation/simulation.h"

#include <algorithm>
#include <utility>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/particles/sort.h"
#include "engine/scene/tree.h"
#include "engine/simulation/initial_state.h"
#include "engine/simulation/simulation_state.h"

namespace whorl {
namespace {

/// Number of steps between two sorts along the space-filling curve, counted from the last frame time.
constexpr long sort_every = 16;

/// Shortens the requested step such that `remaining` is reached exactly and the last two steps are equal.
/// @param wanted smallest limit of the models [s] @param remaining time until the next frame [s]
double fitted_step(double wanted, double remaining) {
    // A tiny remainder (round-off) does not get its own step.
    if (wanted >= remaining * (1 - 1e-9)) return remaining;
    if (wanted > remaining / 2) return remaining / 2;
    return wanted;
}

std::string text_of(const VectorExpression& e) {
    return e.component[0].text() + "; " + e.component[1].text() + "; " + e.component[2].text();
}

}  // namespace

double largest_speed(const World& world) { return largest_speed(world.fluid.column<field::velocity>()); }

Simulation::State::State(const Scene& s, const Plan& p) : scene(calibrated(s)), plan(p), assembly(assemble(scene, p)) {
    declare_fields(assembly.stages, world.fluid);
    world.fluid.declare(field_info<field::position>(), true);
    world.fluid.declare(field_info<field::velocity>(), true);
    world.fluid.declare(field_info<field::role>(), true);
    if (!scene.drains.empty()) world.fluid.declare(field_info<field::time_in_drain>(), true);
    // A live change of fluid.viscosity does not affect the fluid of emitters with their own viscosity.
    const bool own_viscosity =
        std::any_of(scene.emitters.begin(), scene.emitters.end(), [](const EmitterKeys& e) { return e.viscosity.has_value(); });
    if (own_viscosity && world.fluid.has<field::viscosity>()) world.fluid.declare(field_info<field::source>(), true);
    if (scene.any_ink()) world.fluid.declare(field_info<field::ink>(), true);
    if (scene.marks_ink()) {
        world.ink_markers.per_spacing = scene.fluid.ink_markers;
        world.ink_markers.store.declare(field_info<field::position>(), true);
        world.ink_markers.store.declare(field_info<field::ink>(), true);
    }
    if (scene.grains) world.fluid.declare(field_info<field::grain>(), true);
    if (scene.identities) {
        world.fluid.declare(field_info<field::id>(), true);
        world.fluid.declare(field_info<field::source>(), true);
    }
    place_constants(scene, plan, world);
    place_solids(scene, plan, world);
    emitters = make_emitters(scene, plan, world.solids);
    open_walls(emitters, world);
    place_blocks(scene, plan, emitters, world);
    set_ids(world, 0, next_id);
    emit(true);
    measure_rooms();
    drains = make_drains(scene);
    set_gravity();
}

void Simulation::State::set_gravity() {
    const Vec3 now = scene.domain.gravity(time).cast<Real>();
    if (now != world.step.gravity) changing(&EnergyBudget::lifted, [&] { world.step.gravity = now; });
}

void Simulation::State::change(const Scene& now, const Plan& new_plan, double when) {
    steps_since_frame = 0;
    for (std::size_t k = 0; k < now.solids.size(); ++k) {
        Solid& solid = world.solids.all[k];
        solid.contact = {now.solids[k].friction, now.solids[k].bounce};
        if (solid.body) {  // the user moved it
            solid.body->centre += now.solids[k].position(0) - scene.solids[k].position(0);
        } else if (text_of(scene.solids[k].position) != text_of(now.solids[k].position) ||
                   text_of(scene.solids[k].rotation) != text_of(now.solids[k].rotation))
            solid.go_on_as(now.solids[k].position, now.solids[k].rotation, when);
        solid.slip_length = slip_length_of(now.solids[k]);
    }
    for (std::size_t k = 0; k < now.emitters.size(); ++k)
        emitters[k].change(now.emitters[k].speed, now.emitters[k].start, now.emitters[k].stop);
    scene = now, plan = new_plan;
    assembly = assemble(scene, plan);
    const bool had_temperature = world.fluid.has<field::temperature>();
    declare_fields(assembly.stages, world.fluid);
    if (!had_temperature && world.fluid.has<field::temperature>())
        for (Real& T : world.fluid.column<field::temperature>()) T = static_cast<Real>(scene.heat.air);
    place_constants(scene, plan, world);
    world.solids.domain = world.step.domain;
    world.solids.set_time(time, scene.time.look_ahead());
    world.boundary_particles.follow(world.solids);
    set_gravity();
}

double Simulation::State::choose_step(double until) {
    if (scene.time.fixed_step > 0) {
        ++totals.binding["fixed_step"];
        return fitted_step(std::min(scene.time.fixed_step, until - time), until - time);
    }
    const StepLimit* binding = nullptr;
    double wanted = until - time;
    const double fastest = largest_speed(world);
    for (const StepLimit& limit : assembly.limits) {
        const double dt = limit.dt(world, fastest);
        if (dt < wanted) wanted = dt, binding = &limit;
    }
    const double dt = fitted_step(wanted, until - time);
    ++totals.binding[binding != nullptr && dt == wanted ? binding->name : "frame time"];
    return dt;
}

/// @param filling true in the call before the first step, which fills only the pipes that are in fluid
void Simulation::State::emit(bool filling) {
    close_full_rooms();
    for (std::size_t k = 0; k < emitters.size(); ++k) {
        if (filling && !emitters[k].is_full()) continue;
        const Index first = world.fluid.size();
        emitters[k].enter(world.fluid, time, world.step.dt);
        if (world.fluid.size() == first) continue;
        const int source = static_cast<int>(k) + 1;
        const auto temperature = set_temperature(scene, world, first, source, 0, time);
        const auto viscosity = set_viscosity(scene, world, first, source);
        const auto ink = set_colours(scene, world, first, scene.inks_of(scene.emitters[k]), entry_name("emitter", k) + ".ink", time);
        for (const auto& wrong : {temperature, viscosity, ink})
            if (wrong && !world.report.diverged) world.report.diverged = wrong;
        set_ids(world, first, next_id);
    }
}

void Simulation::State::sort() {
    world.fluid.gather(curve_order(std::as_const(world.fluid).column<field::position>(), world.step.support));
}

/// Wraps positions along periodic axes. Removes and counts particles that left the domain along other axes.
void Simulation::State::keep_inside() {
    const auto x = world.fluid.column<field::position>();
    const auto role = world.fluid.column<field::role>();
    const Domain& domain = world.step.domain;
    const auto wrap = [&] { parallel_for(world.fluid.size(), [&](Index i) { x[i] = domain.wrapped(x[i]); }); };
    if (!domain.period().cwiseProduct(world.step.gravity).isZero(0)) changing(&EnergyBudget::lifted, wrap);
    else if (domain.any_periodic()) wrap();
    const Index n = world.fluid.size();
    const auto inside = [&](Index i) { return role[i] < 0 || domain.contains(x[i]); };
    world.report.lost_particles = static_cast<Index>(parallel_sum(n, [&](Index i) { return inside(i) ? 0 : 1; }));
    if (world.report.lost_particles == 0) return;
    std::vector<Index> kept;
    for (Index i = 0; i < n; ++i)
        if (inside(i)) kept.push_back(i);
    changing(&EnergyBudget::drained, [&] { world.fluid.gather(kept); });
    totals.lost_particles += world.report.lost_particles;
}

bool Simulation::State::run_stages() {
    if (energy) energy->begin(world);
    for (const Stage& stage : assembly.stages) {
        if (energy) energy->before(stage, world);
        const double wall = wall_seconds(), cpu = cpu_seconds();
        stage.run(world);
        StageTime& spent = times[stage.group];
        spent.wall += wall_seconds() - wall;
        spent.cpu += cpu_seconds() - cpu;
        ++spent.calls;
        if (energy) energy->after(stage, world, totals.work);
        if (!world.report.diverged) world.report.diverged = find_divergence(stage, world);
        if (!world.report.diverged) world.report.diverged = find_divergent_body(stage, world);
        if (world.report.diverged) return false;
    }
    return true;
}

void Simulation::State::count_solves() {
    for (const StepReport::Solve& solve : world.report.solves) {
        if (solve.kind == SolveKind::pressure || solve.kind == SolveKind::coupled) {
            totals.pressure_iterations += solve.report.iterations;
            totals.pressure_levels = std::max(totals.pressure_levels, solve.report.levels);
            totals.pressure_residual = solve.report.last_residual;
            totals.pressure_set_up += solve.report.set_up_seconds;
            totals.pressure_solve += solve.report.solve_seconds;
        }
        if (solve.kind == SolveKind::viscosity) totals.viscosity_iterations += solve.report.iterations;
        if (!solve.report.converged && solve.kind != SolveKind::crowding) ++totals.unconverged_solves;
    }
}

/// Prepares the input of the stages: time step, solids, emitted fluid, order of the particles.
void Simulation::State::prepare(double dt) {
    world.step.dt = static_cast<Real>(dt);
    world.solids.set_time(time, dt);
    if (world.solids.any_moving()) world.boundary_particles.follow(world.solids);
    emit();
    if (steps_since_frame % sort_every == 0) sort();
}

void Simulation::State::start_step() {
    world.report = {};
    world.solids.clear_ledgers();
    std::fill(world.boundary_particles.pressed.begin(), world.boundary_particles.pressed.end(), Vec3d::Zero());
    world.step.time = time;
    world.step.at_frame_time = steps_since_frame == 0;
    // The solids' velocities are averages over the last step. A resumed run does not know its length, so every run uses look_ahead()
    // at a frame time.
    if (world.step.at_frame_time && world.solids.any_moving()) {
        world.solids.set_time(time, scene.time.look_ahead());
        world.boundary_particles.follow(world.solids);
    }
}

void Simulation::State::count_step(double dt, bool reached) {
    steps_since_frame = reached ? 0 : steps_since_frame + 1;
    ++totals.steps;
    totals.particle_steps += world.fluid.size();
    totals.last_step = dt;
    if (reached && world.report.full.empty()) world.report.full = overfull();
    if (energy && world.report.work) totals.work += *world.report.work;
    count_solves();
}

const StepReport& Simulation::State::step(double until) {
    start_step();
    if (changed_wrongly) {
        changed_wrongly->time = time;
        world.report.diverged = changed_wrongly;
        return world.report;
    }
    const double dt = choose_step(until);
    if (!(dt > 1e-12 * scene.time.end)) {
        std::string what = "the time step collapsed: something moves far too fast";
        if (plan.traits.pressure.source == PressureSource::velocity && plan.free_surface)
            what += " (pressure.form = \"projection\" does not support splashes; \"constraint\" does)";
        if (plan.traits.pressure.source == PressureSource::velocity && !plan.free_surface && scene.solids.size() > 1)
            what +=
                " (solids or gaps between them may be too coarse for pressure.form = \"projection\"; choose a smaller "
                "fluid.spacing, or \"constraint\", which loses more energy)";
        if (const std::string room = overfull(); !room.empty()) what += "; " + room;
        world.report.diverged = Divergence{"time step", "velocity", time, Vec3d::Zero(), what};
        return world.report;
    }
    world.step.to_frame_time = dt == until - time;
    prepare(dt);
    if (world.report.diverged || !run_stages()) return world.report;
    let_out(dt);
    const bool reached = dt == until - time;
    time = reached ? until : time + dt;
    set_gravity();
    count_step(dt, reached);
    return world.report;
}

Simulation::Simulation(const Scene& scene, const Plan& plan) : state_(std::make_unique<State>(scene, plan)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

double Simulation::time() const { return state_->time; }
const RunTotals& Simulation::totals() const { return state_->totals; }
const StageTimes& Simulation::times() const { return state_->times; }
const Scene& Simulation::scene() const { return state_->scene; }
const Plan& Simulation::plan() const { return state_->plan; }
const Assembly& Simulation::assembly() const { return state_->assembly; }
const World& Simulation::world() const { return state_->world; }
const std::vector<Emitter>& Simulation::emitters() const { return state_->emitters; }
const StepReport& Simulation::step(double until) { return state_->step(until); }

void Simulation::count_energy() {
    State& s = *state_;
    s.energy.emplace();
    // Some solvers distribute their residual over the solids. With these, solids at rest must also record impulses if any solid moves.
    const bool shares = s.plan.traits.viscous_implicitly() || s.plan.traits.pressure.source == PressureSource::velocity;
    for (Solid& solid : s.world.solids.all) solid.probed |= shares ? s.world.solids.any_moving() : solid.moves();
    if (!std::exchange(s.totals.any_work, true)) s.totals.work.at_start = s.energy_now();
}

void Simulation::change(const Scene& scene, const Plan& plan, double when) {
    const Scene now = calibrated(scene);
    const bool other_viscosity = state_->scene.fluid.viscosity.text() != now.fluid.viscosity.text();
    state_->change(now, plan, when);
    if (other_viscosity) state_->changed_wrongly = change_viscosity(state_->scene, state_->world);
}
void Simulation::changed_before(const Scene& scene, const Plan& plan, double when) { state_->change(calibrated(scene), plan, when); }

}  // namespace whorl

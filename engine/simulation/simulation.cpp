#include "engine/simulation/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <istream>
#include <ostream>
#include <utility>

#include "engine/core/binary_io.h"
#include "engine/core/parallel.h"
#include "engine/models/ink/ink_markers.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/particles/sort.h"
#include "engine/particles/step_context.h"
#include "engine/scene/scene_shapes.h"
#include "engine/scene/tree.h"
#include "engine/simulation/energy_count.h"
#include "engine/simulation/initial_state.h"
#include "engine/simulation/stage.h"

namespace whorl {
namespace {

/// Number of steps between two sorts along the space-filling curve, counted from the last frame time.
constexpr long sort_every = 16;

/// Refuses impossible values in a saved state, which could crash the run or prevent it from ending.
void must_be_sound(bool is_sound) {
    if (!is_sound) throw EnvironmentError("the saved state is not valid for this scene", "", "resume from an older checkpoint");
}

template <class T>
T take(std::istream& in) {
    T value{};
    if (!whorl::take(in, value)) throw EnvironmentError("the saved state ends too early", "", "resume from an older checkpoint");
    return value;
}
/// A count: at least 0.
template <>
long take(std::istream& in) {
    long value = 0;
    must_be_sound(!whorl::take(in, value) || (value >= 0 && value < 1L << 53));
    return in ? value : 0;
}
template <>
bool take(std::istream& in) {
    return take<char>(in) != 0;
}

std::streamoff bytes_left(std::istream& in) {
    const auto at = in.tellg();
    const auto end = in.seekg(0, std::ios::end).tellg();
    in.seekg(at);
    return end - at;
}

/// Calls f for each number of the totals, in the order of a saved state.
template <class Totals, class F>
void each_number(Totals& t, F&& f) {
    f(t.steps), f(t.particle_steps), f(t.pressure_iterations), f(t.viscosity_iterations);
    f(t.unconverged_solves), f(t.lost_particles), f(t.emitted_particles), f(t.drained_particles), f(t.last_step);
    f(t.work), f(t.any_work);
}

void put_columns(std::ostream& out, const ParticleStore& store) {
    put(out, store.size());
    for (const ParticleStore::Entry* entry : store.entries())
        if (entry->lasting)
            out.write(static_cast<const char*>(std::as_const(*entry->column).data()),
                      static_cast<std::streamsize>(entry->info->bytes * static_cast<std::size_t>(store.size())));
}

void take_columns(std::istream& in, ParticleStore& store) {
    const auto size = take<Index>(in);
    must_be_sound(size >= 0 && size <= bytes_left(in));
    store.resize(size);
    for (const ParticleStore::Entry* entry : store.entries())
        if (entry->lasting) {
            const auto bytes = static_cast<std::streamsize>(entry->info->bytes * static_cast<std::size_t>(size));
            if (!in.read(static_cast<char*>(entry->column->data()), bytes))
                throw EnvironmentError("the saved state ends too early", "", "resume from an older checkpoint");
        }
}

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

struct Simulation::State {
    Scene scene;
    Plan plan;
    World world;
    Assembly assembly;
    std::vector<Emitter> emitters;
    std::vector<Drain> drains;
    double time = 0;
    long steps_since_frame = 0;
    std::int32_t next_id = 0;                   ///< id of the next particle that enters
    std::optional<Divergence> changed_wrongly;  ///< a change gave a particle an invalid viscosity
    std::vector<double> room_left;              ///< number of particles that still fit into each closed room of the plan
    RunTotals totals;
    std::optional<EnergyCount> energy;
    StageTimes times;

    State(const Scene& s, const Plan& p) : scene(calibrated(s)), plan(p), assembly(assemble(scene, p)) {
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

    void set_gravity() {
        const Vec3 now = scene.domain.gravity(time).cast<Real>();
        if (now != world.step.gravity) changing(&EnergyBudget::lifted, [&] { world.step.gravity = now; });
    }

    double energy_now() const { return energies_of(world, world.step.gravity.cast<double>(), plan.spin.micro_inertia).energy(); }
    /// Runs f and attributes the change of the fluid's energy to `cause`.
    template <class F>
    void changing(double EnergyBudget::*cause, F&& f) {
        const double before = energy ? energy_now() : 0;
        f();
        if (energy) totals.work.*cause += energy_now() - before;
    }

    void change(const Scene& now, const Plan& new_plan, double when) {
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

    double choose_step(double until) {
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

    /// Measures how many particles still fit into each closed room when the run begins.
    void measure_rooms() {
        constexpr double densest = 0.97;  // fluid that has flowed in is less dense than a lattice
        const auto x = world.fluid.column<field::position>();
        const auto role = world.fluid.column<field::role>();
        for (const ClosedRoom& room : plan.rooms) {
            const double there = parallel_sum(world.fluid.size(),
                                              [&](Index i) { return role[i] >= 0 && room.box.contains(x[i].cast<double>()) ? 1.0 : 0.0; });
            // The bounding box of the room may also contain other fluid, hence the upper limit.
            room_left.push_back((densest * room.volume - std::min(there * plan.particle_volume(), 1.2 * room.fluid)) /
                                plan.particle_volume());
        }
    }

    /// Closes the emitters of a full room, because they would compress its fluid.
    void close_full_rooms() {
        for (std::size_t k = 0; k < std::min(room_left.size(), plan.rooms.size()); ++k) {
            const ClosedRoom& room = plan.rooms[k];
            double come = 0;
            for (const std::size_t e : room.emitters) come += emitters[e].expected_particles();
            if (come < room_left[k]) continue;
            for (const std::size_t e : room.emitters) emitters[e].close(time);
            const double more = room.coming / plan.particle_volume() - come;
            if (more < 1 || std::exchange(room_left[k], 0) == 0) continue;
            world.report.full = fmt::format(
                "{} is full at {:.4g} s: nothing more enters from {}; {:.3g} m^{} more ({:.0f} particles) would come until the end",
                room.text(), time, room.names(), more * plan.particle_volume(), plan.dimensions(), more);
        }
    }

    /// Warning with the location and amount of fluid that exceeds the available room. Empty unless more than a tenth of the particles are
    /// more than 5 % too dense, whatever the cause (blocks, an emitter or a lid).
    std::string overfull() const {
        constexpr double much = 1.05, few = 0.1;
        const bool splashes = plan.traits.pressure.source == PressureSource::velocity && plan.free_surface;
        if (!world.fluid.has<field::density>() || splashes) return "";
        const auto x = world.fluid.column<field::position>();
        const auto role = world.fluid.column<field::role>();
        const auto rho = world.fluid.column<field::density>();
        const double rho_0 = static_cast<double>(world.step.rest_density);
        const auto excess = [&](Index i) { return role[i] == 0 ? static_cast<double>(rho[i]) / rho_0 - 1 : 0; };
        const auto dense = [&](Index i) { return excess(i) > much - 1; };
        const double count = parallel_sum(world.fluid.size(), [&](Index i) { return dense(i) ? 1.0 : 0.0; });
        if (!(count > few * world.fluid.size())) return "";
        const double more = parallel_sum(world.fluid.size(), [&](Index i) { return dense(i) ? excess(i) : 0.0; });
        ClosedRoom room;
        const Vec3d half = Vec3d(1, 1, plan.dimensions() - 2) * plan.spacing / 2;
        for (Index i = 0; i < world.fluid.size(); ++i)
            if (dense(i)) room.box.extend(x[i].cast<double>() - half), room.box.extend(x[i].cast<double>() + half);
        return fmt::format(
            "more fluid than fits at {:.4g} s in {}: it is {:.2g} % too dense there, {:.3g} m^{} ({:.0f} particles) too much", time,
            room.text(), 100 * more / count, more * plan.particle_volume(), plan.dimensions(), more);
    }

    /// @param filling true in the call before the first step, which fills only the pipes that are in fluid
    void emit(bool filling = false) {
        close_full_rooms();
        int source = 0;
        for (Emitter& emitter : emitters) {
            const Index first = world.fluid.size();
            const auto k = static_cast<std::size_t>(source);
            if (filling && !emitter.is_full()) {
                ++source;
                continue;
            }
            emitter.enter(world.fluid, time, world.step.dt);
            const auto temperature = set_temperature(scene, world, first, ++source, 0, time);
            const auto viscosity = set_viscosity(scene, world, first, source);
            const auto ink = set_colours(scene, world, first, scene.inks_of(scene.emitters[k]), entry_name("emitter", k) + ".ink", time);
            for (const auto& wrong : {temperature, viscosity, ink})
                if (wrong && !world.report.diverged) world.report.diverged = wrong;
            set_ids(world, first, next_id);
        }
    }

    void sort() { world.fluid.gather(curve_order(std::as_const(world.fluid).column<field::position>(), world.step.support)); }

    /// Wraps positions along periodic axes. Removes and counts particles that left the domain along other axes.
    void keep_inside() {
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

    bool run_stages() {
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

    void count_solves() {
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
    void prepare(double dt) {
        world.step.dt = static_cast<Real>(dt);
        world.solids.set_time(time, dt);
        if (world.solids.any_moving()) world.boundary_particles.follow(world.solids);
        emit();
        if (steps_since_frame % sort_every == 0) sort();
    }

    void start_step() {
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

    /// Releases fluid from nozzles, and removes fluid in drains and outside the domain.
    void let_out(double dt) {
        const auto release = [&] {
            for (Emitter& emitter : emitters) totals.emitted_particles += emitter.release(world.fluid, time + dt);
        };
        if (!emitters.empty()) changing(&EnergyBudget::emitted, release);
        for (const Emitter& emitter : emitters) emitter.keep_out(world.fluid);
        const auto take = [&] { totals.drained_particles += drain(world.fluid, drains, world.step.dt); };
        if (!drains.empty()) changing(&EnergyBudget::drained, take);
        keep_inside();
    }

    void count_step(double dt, bool reached) {
        steps_since_frame = reached ? 0 : steps_since_frame + 1;
        ++totals.steps;
        totals.particle_steps += world.fluid.size();
        totals.last_step = dt;
        if (reached && world.report.full.empty()) world.report.full = overfull();
        if (energy && world.report.work) totals.work += *world.report.work;
        count_solves();
    }

    const StepReport& step(double until) {
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
};

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

void Simulation::save(std::ostream& out) const {
    const State& s = *state_;
    WHORL_ASSERT(s.steps_since_frame == 0, "save() between frame times");
    put(out, s.time), put(out, s.next_id);
    each_number(s.totals, [&](const auto& number) { put(out, number); });
    put(out, s.totals.binding.size());
    for (const auto& [limit, times] : s.totals.binding) {
        put(out, limit.size());
        out.write(limit.data(), static_cast<std::streamsize>(limit.size()));
        put(out, times);
    }
    put_columns(out, s.world.fluid), put_columns(out, s.world.ink_markers.store);
    for (const Emitter& emitter : s.emitters) emitter.save(out);
    for (const Solid& solid : s.world.solids.all)
        if (solid.body) solid.body->save(out);
}

void Simulation::load(std::istream& in) {
    State& s = *state_;
    s.time = take<double>(in), s.next_id = take<std::int32_t>(in);
    must_be_sound(std::isfinite(s.time) && s.time >= 0 && s.next_id >= 0);
    s.totals = {};
    each_number(s.totals, [&](auto& number) { number = take<std::remove_reference_t<decltype(number)>>(in); });
    for (auto limits = take<std::size_t>(in); limits > 0; --limits) {
        const auto length = take<std::size_t>(in);
        must_be_sound(length <= static_cast<std::size_t>(bytes_left(in)));
        std::string limit(length, ' ');
        in.read(limit.data(), static_cast<std::streamsize>(length));
        s.totals.binding[limit] = take<long>(in);
    }
    take_columns(in, s.world.fluid), take_columns(in, s.world.ink_markers.store);
    const auto emitters = static_cast<std::int16_t>(s.emitters.size());
    for (const std::int16_t role : s.world.fluid.column<field::role>()) must_be_sound(role >= -emitters);
    if (s.world.fluid.has<field::source>())
        for (const std::int16_t source : s.world.fluid.column<field::source>()) must_be_sound(source >= 0 && source <= emitters);
    for (Emitter& emitter : s.emitters) must_be_sound(emitter.load(in)), emitter.set_time(s.time);
    for (Solid& solid : s.world.solids.all)
        if (solid.body) must_be_sound(solid.body->load(in));
    if (!in) throw EnvironmentError("the saved state ends too early", "", "resume from an older checkpoint");
    s.steps_since_frame = 0;
    s.changed_wrongly = wrong_viscosity(s.world);  // the state may have been saved after a change but before a step that used it
    s.world.step.gravity = scene().domain.gravity(s.time).cast<Real>();
    s.world.step.time = s.time;
    s.world.solids.set_time(s.time, scene().time.look_ahead());
    s.world.boundary_particles.follow(s.world.solids);
}

}  // namespace whorl

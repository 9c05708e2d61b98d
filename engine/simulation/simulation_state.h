#pragma once
/// State of a run, and the parts of a step.
#include "engine/particles/drain.h"
#include "engine/scene/scene_shapes.h"
#include "engine/simulation/energy_count.h"
#include "engine/simulation/simulation.h"

namespace whorl {

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

    State(const Scene& s, const Plan& p);
    void change(const Scene& now, const Plan& new_plan, double when);
    void set_gravity();
    double energy_now() const { return energies_of(world, world.step.gravity.cast<double>(), plan.spin.micro_inertia).energy(); }
    /// Runs f and attributes the change of the fluid's energy to `cause`.
    template <class F>
    void changing(double EnergyBudget::*cause, F&& f) {
        const double before = energy ? energy_now() : 0;
        f();
        if (energy) totals.work.*cause += energy_now() - before;
    }

    const StepReport& step(double until);
    void start_step();
    double choose_step(double until);
    void prepare(double dt);
    void emit(bool filling = false);
    void sort();
    bool run_stages();
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
    void keep_inside();
    void count_step(double dt, bool reached);
    void count_solves();

    void measure_rooms();
    void close_full_rooms();
    std::string overfull() const;
};

}  // namespace whorl

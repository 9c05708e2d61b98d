#pragma once
/// A run in memory: the particles, the stages that the plan asked for, and the step loop.
#include <iosfwd>

#include "engine/core/clock.h"
#include "engine/particles/emitter.h"
#include "engine/scene/scene_difference.h"
#include "engine/simulation/assemble.h"

namespace whorl {

/// max |u| of the fluid [m/s].
double largest_speed(const World& world);

/// Sums over the run up to now.
struct RunTotals {
    long steps = 0;
    double particle_steps = 0;
    double pressure_iterations = 0, viscosity_iterations = 0;
    long unconverged_solves = 0;
    int pressure_levels = 0;                         ///< most levels of the pressure's preconditioner, 1: one
    double pressure_residual = 0;                    ///< of the last solve, in its own norm
    double pressure_set_up = 0, pressure_solve = 0;  ///< wall seconds, since the program started
    long lost_particles = 0;
    double emitted_particles = 0, drained_particles = 0;
    double last_step = 0;  ///< s, the last time step
    EnergyBudget work;     ///< J, since Simulation::count_energy(): any_work
    bool any_work = false;
    std::map<std::string, long> binding;  ///< how often each limit chose the step
};

class Simulation {
public:
    /// Places the fluid and the solids. @throws InputError if the scene cannot be placed
    Simulation(const Scene& scene, const Plan& plan);
    ~Simulation();
    Simulation(Simulation&&) noexcept;

    double time() const;  ///< s
    const RunTotals& totals() const;
    const StageTimes& times() const;  ///< by stage group
    const Scene& scene() const;
    const Plan& plan() const;
    const Assembly& assembly() const;
    const World& world() const;
    const std::vector<Emitter>& emitters() const;

    /// One step, not past the next frame time `until` [s]; one step reaches it exactly (the last two before it are made equal).
    /// A step that starts at a frame time refreshes every lagged set-up, so that a run resumed there is the same run.
    /// If report.diverged is set, the run cannot continue.
    const StepReport& step(double until);

    /// From now on totals().work is kept; solids that move keep ledgers for it. Some passes over the particles per step. Changes no bit of
    /// the run.
    void count_energy();

    /// Replaces the scene from now on: the same fluid, solids and models with other values of the keys that may change
    /// (Key::may_change). Solids continue from their poses at `when` [s], which is not later than time(); the viscosity is that of
    /// `scene` where each particle now is. The next step refreshes every lagged set-up, as at a frame time.
    /// @param plan of `scene`; changes_of_models(plan(), plan) must be empty
    void change(const Scene& scene, const Plan& plan, double when);
    void change(const Scene& scene, const Plan& plan) { change(scene, plan, time()); }
    /// For a run that was resumed with load(): that change was made, for `when` [s], before the state was saved.
    void changed_before(const Scene& scene, const Plan& plan, double when);

    /// All state that lives from step to step. Only at a frame time; bit-exact; the same build reads it back.
    void save(std::ostream& out) const;
    /// @throws EnvironmentError if the data are cut short
    void load(std::istream& in);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace whorl

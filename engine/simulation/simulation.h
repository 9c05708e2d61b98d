#pragma once
/// A run in memory: the particles, the stages of the plan, and the step loop.
#include <iosfwd>

#include "engine/core/clock.h"
#include "engine/particles/emitter.h"
#include "engine/scene/scene_difference.h"
#include "engine/simulation/assemble.h"

namespace whorl {

/// max |u| of the fluid [m/s].
double largest_speed(const World& world);

/// Sums over the run so far.
struct RunTotals {
    long steps = 0;
    double particle_steps = 0;
    double pressure_iterations = 0, viscosity_iterations = 0;
    long unconverged_solves = 0;
    int pressure_levels = 0;                         ///< largest number of levels of the pressure's preconditioner; 1: no hierarchy
    double pressure_residual = 0;                    ///< residual of the last solve, in the norm of that solver
    double pressure_set_up = 0, pressure_solve = 0;  ///< wall time since the program started [s]; not saved
    long lost_particles = 0;
    double emitted_particles = 0, drained_particles = 0;
    double last_step = 0;  ///< s, the last time step
    EnergyBudget work;     ///< energy by cause since Simulation::count_energy() [J]; valid if any_work
    bool any_work = false;
    std::map<std::string, long> binding;  ///< how often each limit determined the step
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

    /// Makes one step, at most up to the next frame time `until` [s]. The last step before `until` ends exactly there; the last two steps
    /// are of equal length. A step that starts at a frame time reuses no neighbours or preconditioners of earlier steps, so that a run
    /// resumed at a frame time is bit-identical. If report.diverged is set, the run cannot continue.
    const StepReport& step(double until);

    /// Counts totals().work from now on. Moving solids then record the impulses of the fluid (Ledger), from which their work follows. Costs
    /// some passes over the particles per step. The run stays bit-identical.
    void count_energy();

    /// Replaces the scene from now on. Fluid, solids and models stay; only keys that may change (Key::may_change) may have other values.
    /// Solids continue from their poses at `when` [s], which is not later than time(). The viscosity is that of `scene` at each particle's
    /// current position. The next step reuses nothing of earlier steps, as at a frame time.
    /// @param plan of `scene`; changes_of_models(plan(), plan) must be empty
    void change(const Scene& scene, const Plan& plan, double when);
    void change(const Scene& scene, const Plan& plan) { change(scene, plan, time()); }
    /// For a run resumed with load(): repeats a change(scene, plan, when) that was made before the state was saved.
    void changed_before(const Scene& scene, const Plan& plan, double when);

    /// Writes all state that persists between steps. Call only at a frame time. The same build reads it back bit-identically.
    void save(std::ostream& out) const;
    /// Restores the state that save() wrote. @throws EnvironmentError if the data end too early or contain impossible values
    void load(std::istream& in);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace whorl

#pragma once
/// The energy budget of a run: the change of the fluid's energy by each stage, attributed to its cause.
#include "engine/simulation/stage.h"

namespace whorl {

/// Energies of the particles outside nozzles [J]: sum m u^2/2, -sum m g . x, sum m theta w^2/2.
struct Energies {
    double kinetic_energy = 0, potential_energy = 0, spin_energy = 0;
    double energy() const { return kinetic_energy + potential_energy + spin_energy; }
};
/// @param gravity m/s^2 @param micro_inertia theta, m^2
Energies energies_of(const World& world, const Vec3d& gravity, double micro_inertia);

/// Observes the stages of a step in order and attributes changes of the fluid's energy to the cause of each stage. A cause gets the change
/// of kinetic energy during its stage, minus the work of solids during that stage, and the change of potential energy. (The potential
/// energy that a push-out changes counts as `moves`.) A stage that adds a force to the acceleration gets the kinetic energy that the force
/// adds in the kick.
///
/// Surface tension pulls particles together, and the pressure solve undoes that in the same step. Therefore a change v of a particle's
/// velocity between the stage of surface tension and the move counts as m v.(u + u')/2. Here u is the velocity before surface tension, and
/// u' is the velocity of the move. These contributions sum to the change of kinetic energy.
class EnergyCount {
public:
    void begin(const World& world);
    void before(const Stage& stage, const World& world);
    void after(const Stage& stage, const World& world, EnergyBudget& budget);

private:
    struct Kick {
        double EnergyBudget::*cause;
        std::vector<Vec3> change;  ///< change of each particle's velocity [m/s]
    };
    void add_kick(double EnergyBudget::*cause, Span<const Vec3> u);
    void count_kicks(const World& world, EnergyBudget& budget);

    std::vector<Kick> kicks_;          ///< changes of velocity since surface tension acted; empty before that and after the move
    std::vector<Vec3> pulled_, last_;  ///< velocities before surface tension acted, and after the last kick
    double kinetic_ = 0, potential_ = 0;
    double work_ = 0;  ///< work of solids so far in this step
    bool accelerated_ = false;
};

}  // namespace whorl

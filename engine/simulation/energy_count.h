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

/// Observes the stages of a step in order. The cause of a stage gets the stage's change of kinetic energy, minus the work of solids in it,
/// and its change of potential energy (except for a push-out, whose change counts as a move). A force that adds to the acceleration gets
/// the kinetic energy that it will have given after the kick. Surface tension pulls particles together, and the solve undoes that in the
/// same step. So from the pulls until the move, a change v of the velocity counts as m v.(u + u')/2, with the velocities u before the
/// pulls and u' of the move; the sum is the change of kinetic energy.
class EnergyCount {
public:
    void begin(const World& world);
    void before(const Stage& stage, const World& world);
    void after(const Stage& stage, const World& world, EnergyBudget& budget);

private:
    struct Kick {
        double EnergyBudget::*cause;
        std::vector<Vec3> change;  ///< of the velocity [m/s]
    };
    void add_kick(double EnergyBudget::*cause, Span<const Vec3> u);
    void count_kicks(const World& world, EnergyBudget& budget);

    std::vector<Kick> kicks_;          ///< kicks since the pulls of surface tension; empty before the pulls and after the move
    std::vector<Vec3> pulled_, last_;  ///< velocities before the pulls, and after the last kick
    double kinetic_ = 0, potential_ = 0;
    double work_ = 0;  ///< work of solids so far in this step
    bool accelerated_ = false;
};

}  // namespace whorl

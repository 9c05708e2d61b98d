#pragma once
/// The energy budget of a run: what each stage does to the fluid's energy, by cause.
#include "engine/sim/stage.h"

namespace whorl {

/// Energies of the particles outside nozzles [J]: sum m u^2/2, -sum m g . x, sum m theta w^2/2.
struct Energies {
    double kinetic_energy = 0, potential_energy = 0, spin_energy = 0;
    double energy() const { return kinetic_energy + potential_energy + spin_energy; }
};
/// @param gravity m/s^2 @param micro_inertia theta, m^2
Energies energies_of(const World& world, const Vec3d& gravity, double micro_inertia);

/// Sees the stages of a step in order. A stage's change of kinetic energy, less the work of solids in it, goes to its cause, and so does
/// its change of potential energy, but that of a push-out, which is a move. Forces that add to the acceleration have the kinetic energy
/// that they will have given when the kick is done.
class EnergyCount {
public:
    void begin(const World& world);
    void after(const Stage& stage, const World& world, EnergyBudget& budget);

private:
    double kinetic_ = 0, potential_ = 0;
    double work_ = 0;  ///< of solids in this step so far
    bool accelerated_ = false;
};

}  // namespace whorl

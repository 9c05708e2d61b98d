#pragma once
/// The energy budget of a run: what each stage does to the fluid's energy, by cause.
#include "engine/sim/stage.h"

namespace whorl {

/// Kinetic, potential and spin energy of the particles outside nozzles [J]. @param micro_inertia theta, m^2
double energy_of(const World& world, double micro_inertia);

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

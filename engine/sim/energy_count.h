#pragma once
/// The energy budget of a run: what each stage does to the fluid's energy, by cause.
#include "engine/sim/stage.h"

namespace whorl {

/// Energy of the particles outside nozzles [J].
struct Energy {
    double kinetic = 0, potential = 0, spin = 0;
    double total() const { return kinetic + potential + spin; }
};

/// @param micro_inertia theta, m^2 @param accelerated kinetic energy with the velocities u + dt a that the step's kick will give
Energy energy_of(const World& world, double micro_inertia, bool accelerated = false);

/// Sees the stages of a step in order. A stage's change of kinetic energy, less the work of solids in it, goes to its cause, and so does
/// its change of potential energy, but that of a push-out, which is a move. Forces that add to the acceleration have the kinetic energy
/// that they will have given when the kick is done.
class EnergyCount {
public:
    void begin(const World& world);
    void after(const Stage& stage, const World& world, EnergyBudget& budget);

private:
    Energy last_;
    double work_ = 0;  ///< of solids in this step so far
    bool accelerated_ = false;
};

}  // namespace whorl

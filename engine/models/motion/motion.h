#pragma once
/// The frame of every step: external acceleration, kick, move. Order: Gravity, (forces that add to the acceleration), Kick,
/// (models that change the velocity: viscosity, pressure), Move, KeepOutside. Kick before Move makes it symplectic Euler.
#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// a = g. The first stage of a step: later ones add to the acceleration.
struct Gravity {
    void operator()(const StepContext& step, Write<field::acceleration> a) const {
        parallel_for(a.size(), [&](Index i) { a[i] = step.gravity; });
    }
};

/// u += dt a for the free particles.
struct Kick {
    void operator()(const StepContext& step, Read<field::role> role, Read<field::acceleration> a, Update<field::velocity> u) const {
        parallel_for(u.size(), [&](Index i) {
            if (role[i] == 0) u[i] += step.dt * a[i];
        });
    }
};

/// x += dt u for all particles, the prescribed ones too. Wrapping on periodic axes is the step loop's part.
struct Move {
    void operator()(const StepContext& step, Read<field::velocity> u, Update<field::position> x) const {
        parallel_for(x.size(), [&](Index i) { x[i] += step.dt * u[i]; });
    }
};

}  // namespace whorl

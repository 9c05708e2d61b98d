#pragma once
/// Stages that every step has: external acceleration, kick, move. Order: Gravity, (forces that add to the acceleration), Kick,
/// (models that change the velocity: viscosity, pressure), Move, PushOutOfSolids. Kick before Move makes the scheme symplectic Euler.
#include <cmath>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/math/expression.h"
#include "engine/math/expression_field.h"
#include "engine/particles/field.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// a = g. First stage of a step; later stages add to the acceleration.
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

/// x += dt u for all particles, prescribed ones included. The step loop wraps positions on periodic axes.
struct Move {
    void operator()(const StepContext& step, Read<field::velocity> u, Update<field::position> x) const {
        parallel_for(x.size(), [&](Index i) { x[i] += step.dt * u[i]; });
    }
};

/// u += dt f(t, x) for the free particles, with f a force per mass [m/s^2]. Runs after Kick and before the solves for the velocity.
class Force {
public:
    explicit Force(VectorExpression f) : f_(std::move(f)) {}
    void operator()(const StepContext& step, Read<field::role> role, Read<field::position> x, Update<field::velocity> u) {
        f_.each(step.time, x.values, [&](Index i, const Vec3& f) {
            if (role[i] == 0) u[i] += step.dt * f;
        });
    }

private:
    ExpressionField f_;
};

struct Stream {
    Vec3 min, max;              ///< m
    VectorExpression velocity;  ///< m/s, of t
    double time = 0;            ///< time in which the difference between the fluid's velocity and `velocity` falls to 1/e [s]
};

/// a += (v - u) (1 - exp(-dt/time))/dt in each box, with v the velocity of the stream. Exact for steps of any length if no other force
/// acts.
struct FollowStreams {
    std::vector<Stream> streams;
    void operator()(const StepContext& step, Read<field::position> x, Read<field::velocity> u, Update<field::acceleration> a) const {
        for (const Stream& stream : streams) {
            const Vec3 v = stream.velocity(step.time).cast<Real>();
            const double dt = static_cast<double>(step.dt);
            const auto rate = static_cast<Real>(-std::expm1(-dt / stream.time) / dt);
            parallel_for(a.size(), [&](Index i) {
                if (Vec3 at = x[i]; step.domain.image_in_box(at, stream.min, stream.max)) a[i] += rate * (v - u[i]);
            });
        }
    }
};

}  // namespace whorl

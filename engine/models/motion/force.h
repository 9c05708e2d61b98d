#pragma once
/// A force on the fluid that differs from place to place.
#include "engine/math/expression_field.h"
#include "engine/particles/field.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// u += dt f(t, x) for the free particles, f over the mass [m/s^2]. After Kick, and before what solves for the velocity.
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

}  // namespace whorl

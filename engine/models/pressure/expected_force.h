#pragma once
/// Use of the last step's pressure force before an implicit viscosity (docs/physics.md 3).
#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

namespace field {
struct pressure_force {
    using type = Vec3;
    static constexpr std::string_view name = "pressure_force", unit = "m/s^2", meaning = "the last step's pressure force over the mass";
};
}  // namespace field

/// Free bodies get the force and torque of the last step before an implicit viscosity, as the fluid gets its pressure. Without them a
/// plate that presses fluid out of a gap of width h would sink faster by a factor of about 1 + 12 nu dt/h^2.
struct ExpectedOnBodies {
    /// Pushes the bodies by the prediction. @param most largest acceleration that is expected again [m/s^2]
    static void expect(const InteractionContext& context, Real most) {
        each(context, [&](RigidBody& body) {
            if (!(body.pressed.force.norm() < static_cast<double>(most) * body.mass)) body.pressed = {};
            body.push(static_cast<double>(context.step.dt) * body.pressed);
        });
    }
    /// Runs before the pressure's solve: takes the prediction back, and stores the momenta for take().
    static void forget(const InteractionContext& context) {
        each(context, [&](RigidBody& body) {
            body.push(-static_cast<double>(context.step.dt) * body.pressed);
            body.pressed = {body.mass * body.velocity, body.spin_momentum};
        });
    }
    /// Runs after the pressure's solve: the change of the momenta is the next prediction.
    static void take(const InteractionContext& context) {
        for (Solid& solid : context.solids.all)
            if (solid.body) {
                Wrench& pressed = solid.body->pressed;
                pressed = {solid.body->mass * solid.body->velocity - pressed.force, solid.body->spin_momentum - pressed.torque};
                pressed = 1 / static_cast<double>(context.step.dt) * pressed;
            }
    }

private:
    template <class Change>
    static void each(const InteractionContext& context, const Change& change) {
        if (!context.solids.any_free()) return;
        for (Solid& solid : context.solids.all)
            if (solid.body) change(*solid.body);
        context.solids.place_bodies();
        context.boundary.follow(context.solids);
    }
};

/// u += dt a, with a the last step's pressure force divided by the mass, so that viscosity acts on a flow whose weight is supported.
/// Without this stage, fluid at rest would slip along no-slip walls at about dt/rho times the pressure gradient.
struct ExpectForce {
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::viscosity> mu, Update<field::pressure_force> a,
                    Update<field::velocity> u) const {
        const StepContext& step = context.step;
        // A larger force, as in an impact, will hardly recur in the next step: it counts as most^2/|a|. Viscosity makes the pressure
        // steady, and reduces what a force moves.
        const Real usual = step.spacing / (10 * step.dt * step.dt), spread = step.dt / (step.rest_density * step.spacing * step.spacing);
        parallel_for(u.size(), [&](Index i) {
            const Real size = a[i].norm(), most = usual * std::max(Real(1), spread * mu[i]);
            if (role[i] != 0 || !std::isfinite(size)) a[i].setZero();
            else if (size > most) a[i] *= most * most / (size * size);
            u[i] += step.dt * a[i];
        });
        ExpectedOnBodies::expect(context, usual);
    }
};

/// Runs before the pressure's solve: u -= dt a. Then stores this u in a, for TakeForce.
struct ForgetForce {
    void operator()(const InteractionContext& context, Update<field::pressure_force> a, Update<field::velocity> u) const {
        parallel_for(u.size(), [&](Index i) { a[i] = u[i] -= context.step.dt * a[i]; });
        ExpectedOnBodies::forget(context);
    }
};

/// Runs after the pressure's solve: a = du/dt.
struct TakeForce {
    void operator()(const InteractionContext& context, Update<field::pressure_force> a, Read<field::velocity> u) const {
        parallel_for(u.size(), [&](Index i) { a[i] = (u[i] - a[i]) / context.step.dt; });
        ExpectedOnBodies::take(context);
    }
};

}  // namespace whorl

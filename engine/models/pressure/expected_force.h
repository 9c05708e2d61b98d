#pragma once
/// The last step's pressure force before an implicit viscosity (docs/physics.md 3).
#include "engine/core/parallel.h"
#include "engine/particles/field.h"
#include "engine/particles/step_context.h"

namespace whorl {

namespace field {
struct pressure_force {
    using type = Vec3;
    static constexpr std::string_view name = "pressure_force", unit = "m/s^2", meaning = "the last step's pressure force over the mass";
};
}  // namespace field

/// u += dt a, a the last step's pressure force over the mass: viscosity then acts on a flow whose weight is held up. Without it fluid at
/// rest slips along sticking walls by about dt/rho times the pressure's gradient.
struct ExpectForce {
    void operator()(const StepContext& step, Read<field::role> role, Update<field::pressure_force> a, Update<field::velocity> u) const {
        const Real most = step.spacing / (10 * step.dt * step.dt);  // an impact's pressure is not expected again
        parallel_for(u.size(), [&](Index i) {
            if (role[i] != 0 || !(a[i].norm() < most)) a[i].setZero();
            u[i] += step.dt * a[i];
        });
    }
};

/// Before the pressure's solve: u -= dt a. Keeps u, for TakeForce.
struct ForgetForce {
    void operator()(const StepContext& step, Update<field::pressure_force> a, Update<field::velocity> u) const {
        parallel_for(u.size(), [&](Index i) { a[i] = u[i] -= step.dt * a[i]; });
    }
};

/// After it: a = du/dt.
struct TakeForce {
    void operator()(const StepContext& step, Update<field::pressure_force> a, Read<field::velocity> u) const {
        parallel_for(u.size(), [&](Index i) { a[i] = (u[i] - a[i]) / step.dt; });
    }
};

}  // namespace whorl

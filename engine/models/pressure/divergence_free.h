#pragma once
/// The constraint in two solves: one for the velocity, from both sides inside the fluid, one for the places of the particles
/// (docs/physics.md 3).
///
/// Stages of a step: DivergenceFree in the place of ConstraintPressure, MoveAndDrift in that of Move.
#include "engine/core/parallel.h"
#include "engine/models/pressure/constraint.h"
#include "engine/particles/surroundings.h"

namespace whorl {

namespace field {
struct packing_pressure {
    using type = Real;
    static constexpr std::string_view name = "packing_pressure", unit = "kg/(m^3 s)",
                                      meaning = "what kept the density in the last step by moving particles";
};
struct drift {
    using type = Vec3;
    static constexpr std::string_view name = "drift", unit = "m/s",
                                      meaning = "by which particles move beside their velocity, to keep the density";
};
}  // namespace field

/// 1. u -= D^T q with  (D u)_i = 0 and q of either sign where rho_i is near rho_0 (inside the fluid: it may pull, too); elsewhere as
/// ConstraintPressure has it, q >= 0 and
///    rho_i + dt (D u)_i <= rho_0, but without a push for what is too dense already.
/// 2. drift = -D^T s with  s >= 0,  rho_i + dt (D (u + drift))_i <= rho_0 but for the share of an excess that is left for later steps.
/// Bodies and solids do not give way. So what keeps the density puts no motion into the fluid, and what expands inside the fluid is held,
/// not only what is compressed.
class DivergenceFree : private ConstraintPressure {
public:
    explicit DivergenceFree(ConstraintOptions options) : ConstraintPressure(std::move(options)) {}
    void operator()(const Surroundings& around, StepReport& report, Read<field::role> role, Write<field::density> rho,
                    Update<field::velocity> u, Update<field::pressure> p, Update<field::packing_pressure> s, Write<field::drift> drift);

private:
    Column<Real> rate_;
    std::vector<char> inside_;
};

/// x += dt (u + drift)
struct MoveAndDrift {
    void operator()(const StepContext& step, Read<field::velocity> u, Read<field::drift> drift, Update<field::position> x) const {
        parallel_for(x.size(), [&](Index i) { x[i] += step.dt * (u[i] + drift[i]); });
    }
};

}  // namespace whorl

#pragma once
/// Viscosity and incompressibility in one symmetric positive definite solve a step, for fluids so viscous that they coil. The stages of a
/// step, in this order, share one CoupledSystem:
///
///   CoupledNeighbourhood   rows, contact gate, moments
///   CoupledSolve           the velocity at the end of the step, the multiplier (pressure), the gradient
///   CoupledMove            x += dt u
///   CoupledShift           close particles part, the velocity goes along: u += G dx
///   CoupledContact         particles that reach a solid stick to it, or slide along it
///
/// Nozzles: prescribed particles (role -k) must fill at least `support` spacings above the opening.
#include <memory>

#include "engine/geometry/solids.h"
#include "engine/models/coupled/fields.h"
#include "engine/models/coupled/slip_friction.h"
#include "engine/models/coupled/two_level.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// What the stages hand to each other within a step, and set-ups that lag. Nothing here lives on beyond a landing.
struct CoupledSystem {
    explicit CoupledSystem(CoupledOptions chosen = {}) : options(chosen) {}
    CoupledOptions options;
    CoupledRows rows;
    StrainForm form;
    ContactFriction friction;
    TwoLevel preconditioner;
    int steps_since_refresh = 0;
    /// Pressures [Pa] that are known beforehand, besides the multiplier: those that surface tension presses the fluid with. Empty: none.
    std::shared_ptr<std::vector<Real>> known_pressure = std::make_shared<std::vector<Real>>();
    std::vector<Vec3> x_before;  ///< positions before the move [m]
};

struct CoupledNeighbourhood {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Read<field::position> x, Read<field::role> role, Write<field::density> density, const StepContext& step) const;
};

struct CoupledSolve {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> mu, Update<field::velocity> u,
                    Update<field::pressure> p, Update<field::velocity_change> change, Update<field::velocity_gradient> G,
                    Update<field::aggregate> aggregate, Update<field::contact_normal> slip, const Solids& solids, const StepContext& step,
                    StepReport& report) const;
};

struct CoupledMove {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Update<field::position> x, Read<field::velocity> u, Read<field::role> role, const Solids& solids,
                    const StepContext& step) const;
};

struct CoupledShift {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Update<field::position> x, Update<field::velocity> u, Read<field::velocity_gradient> G, Read<field::role> role,
                    const StepContext& step) const;
};

struct CoupledContact {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Update<field::position> x, Update<field::velocity> u, Update<field::role> role, Update<field::contact_normal> slip,
                    const Solids& solids, const StepContext& step) const;
};

}  // namespace whorl

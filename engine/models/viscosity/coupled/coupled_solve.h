#pragma once
/// Stages of the coupled model: neighbourhoods, velocity and pressure at the end of the step, the move (coupled_system.h, strain_form.h).
#include "engine/geometry/solids.h"
#include "engine/models/viscosity/coupled/coupled_system.h"
#include "engine/models/viscosity/flow_law.h"
#include "engine/models/viscosity/strain/curvature.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

struct CoupledNeighbourhood {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Read<field::position> x, Read<field::role> role, Write<field::density> density, Update<field::held> held,
                    Update<field::contact_normal> slip, const Solids& solids, const StepContext& step) const;
};

struct CoupledGradient {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Read<field::velocity> u, Write<field::velocity_gradient> G, const Solids& solids, const StepContext& step) const;
};

struct CoupledSolve {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> mu, Update<field::velocity> u,
                    Update<field::pressure> p, Update<field::velocity_change> change, Update<field::velocity_gradient> G,
                    Update<field::aggregate> aggregate, Update<field::contact_normal> slip, const InteractionContext& context,
                    StepReport& report) const;
};

/// CoupledSolve for a fluid whose viscosity depends on the strain rate. field::viscosity is K of the law.
struct CoupledYieldingSolve {
    std::shared_ptr<CoupledSystem> system;
    FlowLaw law;
    void operator()(Read<field::position> x, Read<field::role> role, Read<field::viscosity> K, Update<field::shear_rate> gamma,
                    Write<field::apparent_viscosity> mu, Update<field::velocity> u, Update<field::pressure> p,
                    Update<field::velocity_change> change, Update<field::velocity_gradient> G, Update<field::aggregate> aggregate,
                    Update<field::contact_normal> slip, const InteractionContext& context, StepReport& report) const;
};

struct CoupledMove {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Update<field::position> x, Read<field::velocity> u, Read<field::role> role, const Solids& solids,
                    const StepContext& step) const;
};

struct CoupledShift {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Update<field::position> x, Update<field::velocity> u, Read<field::velocity_gradient> G, Read<field::role> role,
                    Read<field::pressure> pressure, Read<field::viscosity> mu, const StepContext& step) const;
};

struct CoupledYieldingShift {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Update<field::position> x, Update<field::velocity> u, Read<field::velocity_gradient> G, Read<field::role> role,
                    Read<field::pressure> pressure, Read<field::apparent_viscosity> mu, const StepContext& step) const {
        CoupledShift{system}(x, u, G, role, pressure, {mu.values}, step);
    }
};

struct CoupledContact {
    std::shared_ptr<CoupledSystem> system;
    void operator()(Update<field::position> x, Update<field::velocity> u, Read<field::role> role, Update<field::contact_normal> slip,
                    Solids& solids, const StepContext& step) const;
};

}  // namespace whorl

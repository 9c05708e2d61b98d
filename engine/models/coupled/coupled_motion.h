#pragma once
/// How particles move once their velocity is known (coupled_system.h).
#include "engine/geometry/solids.h"
#include "engine/models/coupled/coupled_system.h"
#include "engine/models/strain/curvature.h"
#include "engine/particles/step_context.h"

namespace whorl {

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
    void operator()(Update<field::position> x, Update<field::velocity> u, Read<field::role> role, Update<field::contact_normal> slip,
                    Solids& solids, const StepContext& step) const;
};

}  // namespace whorl

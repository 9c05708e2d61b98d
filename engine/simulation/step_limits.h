#pragma once
/// Limits on the time step, set by the chosen models.
#include <functional>

#include "engine/scene/plan.h"
#include "engine/simulation/world.h"

namespace whorl {

struct StepLimit {
    std::string name;                                        ///< "cfl", "viscous", "sound", "max_step", ...
    std::string formula;                                     ///< text for the plan: "0.4 d / max |u|"
    std::function<double(const World&, double fastest)> dt;  ///< longest step [s]; `fastest`: largest_speed() of the fluid, computed once
                                                             ///< for all limits
};

std::vector<StepLimit> step_limits(const Scene& scene, const Plan& plan);

}  // namespace whorl

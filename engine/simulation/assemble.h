#pragma once
/// Makes the stages of a step, in order, and the limits of its length from the plan. No other file makes the stages of all models.
#include "engine/scene/plan.h"
#include "engine/simulation/stage.h"

namespace whorl {

/// A limit on the time step, set by one of the chosen models.
struct StepLimit {
    std::string name;                                        ///< "cfl", "viscous", "sound", "max_step", ...
    std::string formula;                                     ///< as the plan prints it: "0.4 d / max |u|"
    std::function<double(const World&, double fastest)> dt;  ///< s; `fastest` is largest_speed() of the fluid, computed once for all
                                                             ///< limits
};

/// Stages and limits of a step.
struct Assembly {
    std::vector<Stage> stages;
    std::vector<StepLimit> limits;
};

Assembly assemble(const Scene& scene, const Plan& plan);

}  // namespace whorl

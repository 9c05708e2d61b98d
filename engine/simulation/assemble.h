#pragma once
/// From the plan to the stages of a step, in order, and the limits of its length: the only place that makes the stages of all models.
#include "engine/scene/plan.h"
#include "engine/simulation/stage.h"

namespace whorl {

/// A bound on the time step that one of the chosen models sets.
struct StepLimit {
    std::string name;                                        ///< "cfl", "viscous", "sound", "max_step", ...
    std::string formula;                                     ///< for the plan: "0.4 d / max |u|"
    std::function<double(const World&, double fastest)> dt;  ///< s; fastest: largest_speed() of the fluid, found once for all limits
};

/// Parts of a step.
struct Assembly {
    std::vector<Stage> stages;
    std::vector<StepLimit> limits;
};

Assembly assemble(const Scene& scene, const Plan& plan);

}  // namespace whorl

#pragma once
/// Makes the stages of a step, in order, from the plan. This is the only place that knows the stages of all models.
#include "engine/simulation/stage.h"
#include "engine/simulation/step_limits.h"

namespace whorl {

/// Stages and limits of a step.
struct Assembly {
    std::vector<Stage> stages;
    std::vector<StepLimit> limits;
};

Assembly assemble(const Scene& scene, const Plan& plan);

}  // namespace whorl

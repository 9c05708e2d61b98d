#pragma once
/// Makes the stages of a step, in order, from the plan. This is the only place that knows the stages of all models.
#include "engine/models/motion/motion.h"
#include "engine/simulation/stage.h"
#include "engine/simulation/step_limits.h"

namespace whorl {

/// Stages and limits of a step.
struct Assembly {
    std::vector<Stage> stages;
    std::vector<StepLimit> limits;
};

/// Finds fluid and solid neighbours, for models with one support radius.
Stage neighbours();
/// Moves the solids to the end of the step.
Stage move_solids();
std::vector<Stream> make_streams(const Scene& scene);

Assembly assemble(const Scene& scene, const Plan& plan);

}  // namespace whorl

#pragma once
/// What pressure.form = "projection" cannot hold: with source "velocity" fluid that splashes, with "density" full boxes without weight.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

void check_projection(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems);

}  // namespace whorl

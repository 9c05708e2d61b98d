#pragma once
/// What pressure.form = "projection" with source "velocity" cannot hold: fluid that splashes.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

void check_projection(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems);

}  // namespace whorl

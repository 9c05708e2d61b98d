#pragma once
/// What pressure.form = "projection" cannot hold: fluid that splashes; with source "density" fluid that fills a periodic domain, and fluid
/// between solids that face each other closely.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

void check_projection(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems);

}  // namespace whorl

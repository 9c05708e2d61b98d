#pragma once
/// Models that do not go together although every key is right by itself.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

void check_models(const Scene& scene, const Plan& plan, const SceneNumbers& numbers, std::vector<Problem>& problems);

}  // namespace whorl

#pragma once
/// Free bodies: what cannot be one, and models that do not move them.
#include "engine/scene/plan.h"

namespace whorl {

void check_bodies(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

}  // namespace whorl

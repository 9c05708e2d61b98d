#pragma once
/// What a flow of two dimensions does not have.
#include "engine/scene/plan.h"

namespace whorl {

void check_plane(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

}  // namespace whorl

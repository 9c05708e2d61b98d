#pragma once
/// Keys that are given and that no chosen model reads.
#include "engine/scene/plan.h"

namespace whorl {

/// Of keys that belong to another model than the one that "auto" took, and of those that a chosen form leaves aside. (What the scene itself
/// contradicts is found as it is read.)
void check_unread(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

}  // namespace whorl

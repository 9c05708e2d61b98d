#pragma once
/// What a running simulation cannot follow.
#include <string>
#include <vector>

#include "engine/scene/plan.h"

namespace whorl {

/// A line each: "models.viscosity: none, now full".
std::vector<std::string> changes_of_models(const Plan& running, const Plan& wanted);

}  // namespace whorl

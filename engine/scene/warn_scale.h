#pragma once
/// Sizes that no scene of fluids has, as they come from a wrong unit: each is told with its key, what it means, and the likely slip.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

constexpr double fastest_fluid = 100;  ///< m/s that anybody means; a free fall of 500 m

/// A warning for each opening, domain, speed, density, gravity or solid that is out of proportion.
std::vector<std::string> warnings_of_scale(const Scene& scene, const SceneShapes& shapes);

}  // namespace whorl

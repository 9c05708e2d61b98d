#pragma once
/// Sizes that no scene of fluids has, as they come from a wrong unit: each is told with its key, what it means, and the likely slip.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

constexpr double fastest_fluid = 100;  ///< m/s that anybody means; a free fall of 500 m

struct ScaleWarning {
    std::string key, text;  ///< the text names the key, too
};
/// A warning for each opening, domain, speed, density, gravity or shape that is out of proportion.
std::vector<ScaleWarning> warnings_of_scale(const Scene& scene, const SceneShapes& shapes);

/// The key that makes a shape as large as it is: "radius".
const char* size_key(const ShapeKeys& shape);
/// The likely slip where an opening or a shape is far too large. @param across its size [m]
std::string size_hint(double across);
std::string size_hint(const ShapeKeys& shape, double across);

}  // namespace whorl

#pragma once
/// Scenes that several tests run, as text.
#include <string>

#include "engine/core/types.h"

namespace whorl::test {

/// Honey in a room for a thread 45 mm high: some hundred particles. @param time content of [time] @param more the fluid's shapes, a
/// plate, probes
std::string little_honey(const std::string& time, double spacing, const std::string& more);

/// A lump on the floor and a thread that runs onto it, for little_honey().
inline constexpr const char* lump_and_thread = R"([[block]]
shape = "box"
min = [-0.013, 0.0, -0.013]
max = [0.013, 0.02, 0.013]
[[emitter]]
position = [0, 0.045, 0]
radius = 5e-3
speed = 0.3
)";

/// A viscosity for which this build's Real overflows once fluid is 0.06 s old.
inline const char* const diverging_viscosity = sizeof(Real) == 4 ? "age > 0.06 ? 1e38 : 200" : "age > 0.06 ? 1e307 : 200";

}  // namespace whorl::test

#pragma once
/// bodies.csv: where the free bodies are, a row a body and frame.
#include <string>

#include "engine/sim/world.h"

namespace whorl {

std::string bodies_header();

/// @param gravity m/s^2 at the rows' time
std::string bodies_rows(int frame, double time, const World& world, const Vec3d& gravity);

}  // namespace whorl

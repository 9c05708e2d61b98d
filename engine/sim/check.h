#pragma once
/// Finds what went wrong in a step: values that are not finite.
#include "engine/sim/stage.h"

namespace whorl {

/// The first particle (lowest index) with a non-finite value in a field that the stage wrote; nothing where all is well.
std::optional<Divergence> find_divergence(const Stage& stage, const World& world);
/// The first free body whose state is not finite; nothing where all is well.
std::optional<Divergence> find_divergent_body(const Stage& stage, const World& world);

}  // namespace whorl

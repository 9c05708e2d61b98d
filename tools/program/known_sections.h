#pragma once
/// The sections of a scene file that are none of the engine's, as tables only: for the schema and the reference page.
#include <vector>

#include "engine/scene/read.h"

namespace whorl {

std::vector<Section> known_sections();

}  // namespace whorl

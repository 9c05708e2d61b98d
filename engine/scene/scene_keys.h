#pragma once
/// The keys of the engine's own sections of a scene file.
#include "engine/core/keys.h"

namespace whorl {

const KeyTable& scene_keys();
/// What output.export may ask for; each is the name of a folder in the run folder, too.
const std::vector<std::string>& export_kinds();

}  // namespace whorl

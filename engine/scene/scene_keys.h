#pragma once
/// The keys of the engine's own sections of a scene file.
#include "engine/core/keys.h"

namespace whorl {

const KeyTable& scene_keys();

}  // namespace whorl

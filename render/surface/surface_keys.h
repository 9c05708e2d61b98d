#pragma once
/// The keys of [surface] in a scene file.
#include "engine/core/keys.h"

namespace whorl {

const KeyTable& surface_keys();  ///< of SurfaceOptions

}  // namespace whorl

#pragma once
/// The keys of [camera] and [look] in a scene file.
#include "engine/core/keys.h"
#include "render/look/camera.h"

namespace whorl {

const KeyTable& camera_keys();  ///< of CameraOptions
const KeyTable& look_keys();    ///< of LookOptions

}  // namespace whorl

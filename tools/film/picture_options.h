#pragma once
/// How a picture is made; a scene may change it from frame to frame.
#include "render/look/camera.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"

namespace whorl {

struct PictureOptions {
    SurfaceOptions surface;
    CameraOptions camera;
    LookOptions look;
};

}  // namespace whorl

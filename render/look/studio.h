#pragma once
/// The studio that things stand in: backdrop and soft boxes. They turn with the camera, as if the things stood on a turntable, so that
/// every view is well lit.
#include <string>
#include <vector>

#include "render/look/camera.h"
#include "render/look/look_options.h"

namespace whorl {

/// Radiances, linear RGB.
struct Studio {
    Vec3f backdrop_low, backdrop_high, backdrop_glow;
    Vec3f key, window, rim, fill;  ///< the soft boxes; the window is the shadow light
    Vec3f sky;                     ///< the light that falls on a body from all round
    Vec3f sun;                     ///< what the shadow light adds on a white surface that faces it
};
/// studio | dark | white; transparent and any other name: studio.
Studio studio_of(const std::string& background);
std::vector<std::string> background_names();

/// World -> studio: x to the right of the picture, y up, z towards the viewer.
Mat3f studio_axes(const View& view);
/// Where the light that throws the shadow stands, in the studio's axes, unit length: high, behind and to the left, so that light comes
/// through the fluid and its shadow falls towards the viewer.
Vec3f shadow_light();
/// The same of the lamp that lights clouds: the first soft box, at the viewer's left.
Vec3f lamp_of_clouds();

}  // namespace whorl

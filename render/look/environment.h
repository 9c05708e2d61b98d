#pragma once
/// A panorama of a scene's surroundings, and its light.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"

namespace whorl {

// The studio around the scene: backdrop and soft boxes. They turn with the camera, as if the scene were on a turntable, so that
// every view is well lit.

/// Radiances, linear RGB.
struct Studio {
    Vec3f backdrop_low, backdrop_high, backdrop_glow;
    Vec3f key, window, rim, fill;  ///< the soft boxes; the window is the shadow light
    Vec3f sky;                     ///< the light that falls on a body from all round
    Vec3f sun;                     ///< the shadow light's illumination of a white surface that faces it
};
/// studio | dark | white; transparent and any other name: studio.
Studio studio_of(const std::string& background);
std::vector<std::string> background_names();

/// World -> studio: x to the right of the picture, y up, z towards the viewer.
Mat3f studio_axes(const View& view);
/// Direction to the light that casts the shadow, in the studio's axes, unit length: high, behind and to the left, so that light comes
/// through the fluid and its shadow falls towards the viewer.
Vec3f shadow_light();
/// Direction to the lamp that lights clouds: the first soft box, at the viewer's left.
Vec3f lamp_of_clouds();

/// Radiances, linear RGB. Rows from the zenith down, columns round the horizon; the middle column lies towards -z, what is right of it
/// towards +x.
struct Environment {
    int width = 0, height = 0;
    std::vector<float> rgb;
    Vec3f at(int x, int y) const;
    Vec3f direction(int x, int y) const;  ///< unit, of the pixel's middle
};

/// An OpenEXR picture, as cameras and Poly Haven make them. Values that are no light (negative, not finite) are 0.
/// @throws InputError as read_exr()
Environment read_environment(const std::filesystem::path& file);

/// Light of the picture on a white matt surface, over pi, in spherical harmonics up to the second order: within 3 % of the integral
/// for a picture without a small lamp (Ramamoorthi and Hanrahan, SIGGRAPH 2001). The terms 1, y, z, x, xy, yz, 3z^2 - 1, xz, x^2 - y^2.
std::array<Vec3f, 9> light_of(const Environment& environment);
Vec3f light_on(const std::array<Vec3f, 9>& light, const Vec3f& normal);

/// Direction of most of the light, unit, at least 35 degrees above the horizon: shadows fall away from there.
Vec3f brightest_side(const std::array<Vec3f, 9>& light);

}  // namespace whorl

#pragma once
/// Light around a scene: the studio, or a panorama of the surroundings.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"

namespace whorl {

// The studio is a backdrop with soft boxes. It turns with the camera, as if the scene were on a turntable, so that every view is well lit.

/// Radiances of the studio, linear RGB.
struct Studio {
    Vec3f backdrop_low, backdrop_high, backdrop_glow;
    Vec3f key, window, rim, fill;  ///< the soft boxes; the window is the shadow light
    Vec3f sky;                     ///< ambient light, from all directions
    Vec3f sun;                     ///< illumination of a white surface that faces the shadow light
};
/// The studio with all radiances multiplied by a factor.
Studio scaled(Studio studio, float factor);
/// studio | dark | white; transparent and any other name: studio.
Studio studio_of(const std::string& background);
std::vector<std::string> background_names();

/// Rotation from world to studio axes: x to the right of the image, y up, z towards the viewer.
Mat3f studio_axes(const View& view);
/// Rotation about y by an angle [degrees] that undoes the turn of a surround: world -> axes of a panorama, studio -> axes of its lamps.
Mat3f turned_back(float degrees);
/// Direction to the light that casts the shadow, unit vector in studio axes: high, behind and to the left. The light passes through the
/// fluid, and the shadow falls towards the viewer.
Vec3f shadow_light();
/// Direction to the lamp that lights clouds, unit vector in studio axes: the first soft box, at the viewer's left.
Vec3f lamp_of_clouds();

/// Panorama of radiances, linear RGB. Rows run from the zenith down, columns round the horizon. The middle column looks towards -z, the
/// columns to its right towards +x.
struct Environment {
    int width = 0, height = 0;
    std::vector<float> rgb;
    Vec3f at(int x, int y) const;
    Vec3f direction(int x, int y) const;  ///< unit vector to the pixel's centre
};

/// Reads an OpenEXR panorama, as cameras and Poly Haven make them. Negative and non-finite values become 0.
/// @throws InputError as read_exr()
Environment read_environment(const std::filesystem::path& file);

/// Irradiance over pi, that is the radiance of a white matt surface, as coefficients of 1, y, z, x, xy, yz, 3z^2 - 1, xz, x^2 - y^2 of
/// the surface normal (spherical harmonics up to second order). It is within 3 % of the integral if the panorama contains no small lamp
/// (Ramamoorthi and Hanrahan, SIGGRAPH 2001).
std::array<Vec3f, 9> light_of(const Environment& environment);
/// Value of the series of light_of() for a unit normal, at least 0.
Vec3f light_on(const std::array<Vec3f, 9>& light, const Vec3f& normal);

/// Direction that most of the light comes from, unit vector, raised to at least 35 degrees above the horizon. Shadows are cast from it.
Vec3f brightest_side(const std::array<Vec3f, 9>& light);

}  // namespace whorl

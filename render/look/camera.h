#pragma once
/// Camera of an image.
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

struct CameraKey {
    double time = 0;  ///< s
    Vec3f position = Vec3f(0, 0.1f, 0.4f), target = Vec3f::Zero();
    float fov = 30;  ///< degrees, vertical
};

using ShownBox = std::array<Vec3f, 2>;  ///< lower and upper corner [m]

/// The camera at one moment.
struct View {
    Vec3f position, target, up;
    float fov;                         ///< degrees, vertical
    bool flat = false;                 ///< set by the auto camera: a slice may fill the image instead of being drawn in perspective
    std::optional<ShownBox> box = {};  ///< box that the auto camera is told to show
    float aperture = 0, focus = 0;     ///< m, diameter of the lens, and distance that is sharp
    float open = 0;                    ///< s, simulated time that the shutter is open, centred on the frame's time
    Vec3f position_velocity = Vec3f::Zero(), target_velocity = Vec3f::Zero();  ///< m/s, simulated time; 0 if `open` is 0
    bool blurs() const { return aperture > 0 || open > 0; }
};

/// kind "fixed": from `position` towards `target`. "orbit": turns about `target` at `distance`, `height`, `degrees_per_second`, from
/// `start_angle`. "keys": smooth (Catmull-Rom) through `keys`. "animation": follows the node of a glTF file. "auto" (default): shows the
/// whole box from `min` to `max`, from 25 degrees to the right of +z and 14 degrees above the horizon. A domain without depth is shown from
/// +z.
struct CameraOptions {
    std::string kind = "auto";
    Vec3f position = Vec3f(0, 0.1f, 0.4f), target = Vec3f::Zero(), up = Vec3f(0, 1, 0);
    float fov = 30;  ///< degrees, vertical
    float distance = 0.4f, height = 0.1f, start_angle = 0, degrees_per_second = 20;
    std::vector<CameraKey> keys;
    std::filesystem::path animation;  ///< glTF file
    std::string node;
    std::function<View(double time)> path;  ///< motion of the node; not a key
    std::optional<Vec3f> min, max;          ///< m, corners of the box that "auto" shows; none: the domain's
    float aspect = 16.0f / 9;               ///< width of the image over its height; follows from the scene's output
    float aperture = 0;                     ///< m, diameter of the lens; 0: everything is sharp
    std::optional<float> focus;             ///< m, distance that is sharp; none: the target's
    float shutter = 180;                    ///< degrees, share of `interval` during which the shutter is open; 360: all of it
    double interval = 0;                    ///< s, simulated time between two images; follows from the scene's fps and slow motion

    /// The box to show, if both corners are set.
    std::optional<ShownBox> box() const { return min && max ? std::optional<ShownBox>({*min, *max}) : std::nullopt; }
};

/// Rotation from world to camera axes. Its rows are the unit vectors to the right, up, and from the target to the eye.
Mat3f camera_axes(const View& view);
/// @param time of the frame [s], simulated
View view_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max);

}  // namespace whorl

#pragma once
/// Camera of an image.
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

/// kind "fixed": position, target. "orbit": turns about `target` at `distance`, `height`, `degrees_per_second`, from `start_angle`.
/// "keys": smooth (Catmull-Rom) through `keys`. "auto" (default): all of the box from `min` to `max`, from a pleasing angle; what has no
/// depth from ahead.
struct CameraOptions {
    std::string kind = "auto";
    Vec3f position = Vec3f(0, 0.1f, 0.4f), target = Vec3f::Zero(), up = Vec3f(0, 1, 0);
    float fov = 30;  ///< degrees, vertical
    float distance = 0.4f, height = 0.1f, start_angle = 0, degrees_per_second = 20;
    std::vector<CameraKey> keys;
    std::optional<Vec3f> min, max;  ///< m, corners of the extent that "auto" shows; none: the domain's
    float aspect = 16.0f / 9;       ///< of the picture, width over height: follows from the scene's output
    float aperture = 0;             ///< m, diameter of the lens; 0: all is sharp
    std::optional<float> focus;     ///< m ahead, where it is sharp; none: at the target
    float shutter = 180;            ///< degrees: open for this part of the time between two pictures, 360 for all of it
    double interval = 0;            ///< s, simulated, between two pictures: follows from the scene's fps and slow motion
};

/// The camera at one moment.
struct View {
    Vec3f position, target, up;
    float fov;                      ///< degrees, vertical
    bool flat = false;              ///< auto camera: a slice may fill the image instead of being placed in the world
    float aperture = 0, focus = 0;  ///< m, of the lens
    float open = 0;                 ///< s, simulated, that the shutter is open, about the frame's time
    Vec3f position_velocity = Vec3f::Zero(), target_velocity = Vec3f::Zero();  ///< m/s of simulated time; where the shutter opens at all
    bool blurs() const { return aperture > 0 || open > 0; }
};
/// World -> camera: rows to the right, up, and back to the eye.
Mat3f camera_axes(const View& view);
View view_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max);

}  // namespace whorl

#pragma once
/// Where a picture is taken from.
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
/// "keys": smooth (Catmull-Rom) through `keys`. "auto" (default): frames the domain from a pleasing angle, one without depth from ahead.
struct CameraOptions {
    std::string kind = "auto";
    Vec3f position = Vec3f(0, 0.1f, 0.4f), target = Vec3f::Zero(), up = Vec3f(0, 1, 0);
    float fov = 30;  ///< degrees, vertical
    float distance = 0.4f, height = 0.1f, start_angle = 0, degrees_per_second = 20;
    std::vector<CameraKey> keys;
};

/// The camera at one moment.
struct View {
    Vec3f position, target, up;
    float fov;          ///< degrees, vertical
    bool flat = false;  ///< of an auto camera: a slice need not stand in the world, it may fill the picture
};
View view_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max);

}  // namespace whorl

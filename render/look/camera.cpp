#include "render/look/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/core/smooth_keys.h"

namespace whorl {
namespace {

float radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180; }

/// The nearest view of a whole box from the direction `away` (unit vector from the target to the eye).
View framed(const CameraOptions& camera, const Vec3f& low, const Vec3f& high, const Vec3f& away) {
    constexpr float margin = 1.12f;
    const Vec3f side = camera.up.cross(away).normalized(), above = away.cross(side), middle = 0.5f * (low + high);
    // A corner at (h, v, z) along side, above and away is in the image from an eye at (H, V, Z) if
    // |h - H| <= wide (Z - z) and |v - V| <= tall (Z - z).
    const float tall = std::tan(0.5f * radians(camera.fov)) / margin, wide = camera.aspect * tall;
    const auto fit = [&](const Vec3f& axis, float slope) {
        float from = 1e30f, to = -1e30f;
        for (int corner = 0; corner < 8; ++corner) {
            Vec3f x = -middle;
            for (int a = 0; a < 3; ++a) x[a] += (corner >> a) & 1 ? high[a] : low[a];
            from = std::min(from, x.dot(axis) - slope * x.dot(away)), to = std::max(to, x.dot(axis) + slope * x.dot(away));
        }
        return std::array<float, 2>{0.5f * (from + to), 0.5f * (to - from) / slope};
    };
    const auto [h, far_for_width] = fit(side, wide);
    const auto [v, far_for_height] = fit(above, tall);
    const Vec3f target = middle + h * side + v * above;
    return {target + std::max(far_for_width, far_for_height) * away, target, camera.up, camera.fov};
}

View between_keys(const CameraOptions& camera, double time) {
    const std::vector<CameraKey> keys = by_time(camera.keys);
    const auto at = [&](const auto& number) { return static_cast<float>(smooth_between(keys, time, number).value); };
    View found{Vec3f::Zero(), Vec3f::Zero(), camera.up, at([](const CameraKey& key) { return key.fov; })};
    for (int axis = 0; axis < 3; ++axis) {
        found.position[axis] = at([axis](const CameraKey& key) { return key.position[axis]; });
        found.target[axis] = at([axis](const CameraKey& key) { return key.target[axis]; });
    }
    return found;
}

View pose_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max) {
    if (camera.kind == "fixed") return {camera.position, camera.target, camera.up, camera.fov};
    if (camera.kind == "keys" && !camera.keys.empty()) return between_keys(camera, time);
    if (camera.kind == "animation" && camera.path) return camera.path(time);
    if (camera.kind == "orbit") {
        const float angle = radians(camera.start_angle + camera.degrees_per_second * static_cast<float>(time));
        const Vec3f offset(camera.distance * std::sin(angle), camera.height, camera.distance * std::cos(angle));
        return {camera.target + offset, camera.target, camera.up, camera.fov};
    }
    const float azimuth = radians(25), elevation = radians(14);
    const Vec3f from_above(std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation));
    const bool plane = !(domain_min.z() < domain_max.z());
    View view = framed(camera, camera.min.value_or(domain_min), camera.max.value_or(domain_max), plane ? Vec3f::UnitZ() : from_above);
    view.flat = true;
    view.box = camera.box();
    return view;
}

}  // namespace

Mat3f camera_axes(const View& view) {
    const Vec3f forward = (view.target - view.position).normalized();
    Vec3f right = forward.cross(view.up);
    if (right.norm() < 1e-3f) right = forward.cross(std::abs(view.up.x()) < 0.9f ? Vec3f::UnitX() : Vec3f::UnitZ());
    right.normalize();
    Mat3f axes;
    axes << right.transpose(), right.cross(forward).transpose(), -forward.transpose();
    return axes;
}

View view_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max) {
    View view = pose_at(camera, time, domain_min, domain_max);
    view.aperture = camera.aperture;
    view.focus = camera.focus.value_or((view.target - view.position).norm());
    view.open = static_cast<float>(camera.shutter / 360 * camera.interval);
    if (view.open <= 0) return view;
    const View ahead = pose_at(camera, time + 0.5 * static_cast<double>(view.open), domain_min, domain_max);
    const View back = pose_at(camera, time - 0.5 * static_cast<double>(view.open), domain_min, domain_max);
    view.position_velocity = (ahead.position - back.position) / view.open;
    view.target_velocity = (ahead.target - back.target) / view.open;
    return view;
}

}  // namespace whorl

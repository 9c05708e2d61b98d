#include "render/look/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

/// The cubic from key 1 to key 2 of four. The slopes are those of Catmull and Rom for unevenly spaced times, limited so that the cubic
/// does not overshoot a key (Fritsch and Carlson 1980). So the value is constant between equal keys.
float through(const std::array<double, 4>& x, const std::array<double, 4>& time, double now) {
    const double span = time[2] - time[1], rise = (x[2] - x[1]) / span, s = (now - time[1]) / span;
    const auto slope_at = [&](std::size_t key, std::size_t from) {  // from, from + 1: the span on the other side of the key
        if (!(time[from] < time[from + 1])) return rise;            // the first or last key, or a cut (two keys at one time)
        const double other = (x[from + 1] - x[from]) / (time[from + 1] - time[from]), most = 3 * std::min(std::abs(rise), std::abs(other));
        if (std::signbit(rise) != std::signbit(other)) return 0.0;
        return std::clamp((x[key + 1] - x[key - 1]) / (time[key + 1] - time[key - 1]), -most, most);
    };
    const double out = slope_at(1, 0) * span, in = slope_at(2, 2) * span, s2 = s * s, s3 = s2 * s;
    return static_cast<float>(x[1] + (3 * s2 - 2 * s3) * (x[2] - x[1]) + (s3 - 2 * s2 + s) * out + (s3 - s2) * in);
}

View between_keys(const CameraOptions& camera, double time) {
    std::vector<CameraKey> keys = camera.keys;
    std::stable_sort(keys.begin(), keys.end(), [](const CameraKey& a, const CameraKey& b) { return a.time < b.time; });
    const auto view = [&](const CameraKey& key) { return View{key.position, key.target, camera.up, key.fov}; };
    if (time <= keys.front().time) return view(keys.front());
    if (time >= keys.back().time) return view(keys.back());
    std::size_t i = 0;
    while (keys[i + 1].time <= time) ++i;
    const CameraKey &a = keys[i > 0 ? i - 1 : 0], &b = keys[i], &c = keys[i + 1], &d = keys[std::min(i + 2, keys.size() - 1)];
    const std::array<double, 4> times{a.time, b.time, c.time, d.time};
    const auto between = [&](const auto& number) { return through({number(a), number(b), number(c), number(d)}, times, time); };
    View found{Vec3f::Zero(), Vec3f::Zero(), camera.up, between([](const CameraKey& key) { return key.fov; })};
    for (int axis = 0; axis < 3; ++axis) {
        found.position[axis] = between([axis](const CameraKey& key) { return key.position[axis]; });
        found.target[axis] = between([axis](const CameraKey& key) { return key.target[axis]; });
    }
    return found;
}

View pose_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max) {
    if (camera.kind == "fixed") return {camera.position, camera.target, camera.up, camera.fov};
    if (camera.kind == "keys" && !camera.keys.empty()) return between_keys(camera, time);
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

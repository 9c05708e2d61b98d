#include "render/look/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace whorl {
namespace {

float radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180; }

/// The whole of a domain without depth, from ahead.
View framed_plane(const CameraOptions& camera, const Vec3f& low, const Vec3f& high) {
    const Vec3f size = high - low, target = 0.5f * (low + high);
    const float distance = 0.5f * 1.06f * std::max(size.y(), size.x() * 9.0f / 16.0f) / std::tan(0.5f * radians(camera.fov));
    return {target + Vec3f(0, 0, distance), target, camera.up, camera.fov};
}

/// Frames the domain, and nothing that moves in it: the picture must not jump. The whole height is seen; sides may be cut, for a domain is
/// mostly air at its sides.
View framed(const CameraOptions& camera, const Vec3f& low, const Vec3f& high) {
    const Vec3f size = high - low;
    const float azimuth = radians(25), elevation = radians(14);
    const Vec3f away(std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation));
    const float depth = std::hypot(size.x(), size.z());
    const float tall = size.y() * std::cos(elevation) + depth * std::sin(elevation) * 0.5f;
    const float wide = depth * 9.0f / 16.0f;  // a film is wider than high
    const float distance = 0.5f * 1.06f * std::max(tall, 0.8f * wide) / std::tan(0.5f * radians(camera.fov)) + 0.25f * depth;
    const Vec3f target = 0.5f * (low + high) - Vec3f(0, 0.02f * size.y(), 0);
    return {target + distance * away, target, camera.up, camera.fov};
}

/// Catmull-Rom through b (at 0) and c (at 1), with tangents for keys that are not evenly spaced in time.
template <class T>
T through(const T& a, const T& b, const T& c, const T& d, const std::array<double, 4>& time, double now) {
    const double span = time[2] - time[1];
    const float s = static_cast<float>((now - time[1]) / span);
    const auto slope = [&](const T& from, const T& to, double t0, double t1) -> T {
        return (to - from) * static_cast<float>(t1 > t0 ? span / (t1 - t0) : 0);
    };
    const T out = slope(a, c, time[0], time[2]), in = slope(b, d, time[1], time[3]);
    const float s2 = s * s, s3 = s2 * s;
    return (2 * s3 - 3 * s2 + 1) * b + (s3 - 2 * s2 + s) * out + (3 * s2 - 2 * s3) * c + (s3 - s2) * in;
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
    return {through<Vec3f>(a.position, b.position, c.position, d.position, times, time),
            through<Vec3f>(a.target, b.target, c.target, d.target, times, time), camera.up,
            through<float>(a.fov, b.fov, c.fov, d.fov, times, time)};
}

}  // namespace

namespace {

View standing_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max) {
    if (camera.kind == "fixed") return {camera.position, camera.target, camera.up, camera.fov};
    if (camera.kind == "keys" && !camera.keys.empty()) return between_keys(camera, time);
    if (camera.kind == "orbit") {
        const float angle = radians(camera.start_angle + camera.degrees_per_second * static_cast<float>(time));
        const Vec3f offset(camera.distance * std::sin(angle), camera.height, camera.distance * std::cos(angle));
        return {camera.target + offset, camera.target, camera.up, camera.fov};
    }
    View view = domain_min.z() < domain_max.z() ? framed(camera, domain_min, domain_max) : framed_plane(camera, domain_min, domain_max);
    view.flat = true;
    return view;
}

}  // namespace

View view_at(const CameraOptions& camera, double time, const Vec3f& domain_min, const Vec3f& domain_max) {
    View view = standing_at(camera, time, domain_min, domain_max);
    view.aperture = camera.aperture;
    view.focus = camera.focus.value_or((view.target - view.position).norm());
    view.open = static_cast<float>(camera.shutter / 360 * camera.interval);
    if (view.open <= 0) return view;
    const View ahead = standing_at(camera, time + 0.5 * static_cast<double>(view.open), domain_min, domain_max);
    const View back = standing_at(camera, time - 0.5 * static_cast<double>(view.open), domain_min, domain_max);
    view.position_velocity = (ahead.position - back.position) / view.open;
    view.target_velocity = (ahead.target - back.target) / view.open;
    return view;
}

}  // namespace whorl

#include "render/look/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace whorl {
namespace {

float radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180; }

/// All of a box, from the direction `away` [unit], as near as its corners allow.
View framed(const CameraOptions& camera, const Vec3f& low, const Vec3f& high, const Vec3f& away) {
    constexpr float margin = 1.12f;
    const Vec3f side = camera.up.cross(away).normalized(), above = away.cross(side), middle = 0.5f * (low + high);
    // A corner at (h, v, z) along side, above and away lies in a picture from (H, V, Z) where
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
    const float azimuth = radians(25), elevation = radians(14);
    const Vec3f from_above(std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation));
    const bool plane = !(domain_min.z() < domain_max.z());
    View view = framed(camera, camera.min.value_or(domain_min), camera.max.value_or(domain_max), plane ? Vec3f::UnitZ() : from_above);
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

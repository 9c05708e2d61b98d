#include "tools/scene_file/camera_warnings.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "engine/scene/frame_times.h"

namespace whorl {
namespace {

constexpr float least_part = 0.02f;  ///< of the picture's height that the domain should take
constexpr int points = 9;            ///< of the domain, an axis

std::string point(const Vec3f& x) { return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", x.x(), x.y(), x.z()); }

/// What a picture from there would show of the box.
struct Seen {
    bool any = false;
    float part = 0;  ///< of the picture's height that it takes, at most 1
};
Seen seen_from(const View& view, float aspect, const Vec3f& low, const Vec3f& high) {
    const Vec3f ahead = (view.target - view.position).normalized(), side = ahead.cross(view.up).normalized(), above = side.cross(ahead);
    const float tall = std::tan(0.5f * view.fov * std::numbers::pi_v<float> / 180), wide = aspect * tall;
    Seen seen;
    float bottom = 1, top = -1;
    for (int i = 0; i < points; ++i)
        for (int j = 0; j < points; ++j)
            for (int k = 0; k < points; ++k) {
                const Vec3f part = Vec3f(float(i), float(j), float(k)) / (points - 1);
                const Vec3f x = low + part.cwiseProduct(high - low) - view.position;
                const float depth = x.dot(ahead);
                if (depth <= 0) continue;
                const float h = x.dot(side) / (depth * wide), v = x.dot(above) / (depth * tall);
                if (std::abs(h) > 1 || std::abs(v) > 1) continue;
                seen.any = true;
                bottom = std::min(bottom, v), top = std::max(top, v);
            }
    seen.part = seen.any ? (top - bottom) / 2 : 0;
    return seen;
}

std::string key_of(const CameraOptions& camera, double time) {
    for (std::size_t k = 0; camera.kind == "keys" && k < camera.keys.size(); ++k)
        if (camera.keys[k].time == time) return fmt::format("camera.key[{}]", k);
    return "camera";
}

}  // namespace

std::vector<std::string> camera_warnings(const SceneFile& file) {
    const CameraOptions& camera = file.camera;
    const Scene& scene = file.scene;
    if (!scene.output.frames || (camera.kind == "auto" && !camera.min)) return {};
    std::vector<double> times{0, 0.5 * scene.time.end, scene.time.end};
    const bool still = camera.kind == "fixed" || camera.kind == "auto";
    if (still) times = {0};
    for (const CameraKey& key : camera.keys)
        if (camera.kind == "keys" && key.time <= scene.time.end) times.push_back(key.time);
    const Vec3f low = scene.domain.min.cast<float>(), high = scene.domain.max.cast<float>(), middle = 0.5f * (low + high);
    const float aspect = static_cast<float>(scene.output.size[0]) / static_cast<float>(scene.output.size[1]);
    for (const double time : times) {
        const View view = view_at(camera, time, low, high);
        const std::string key = key_of(camera, time), when = still ? "" : fmt::format(" at {:g} s", time);
        const Vec3f ahead = view.target - view.position;
        if (ahead.norm() <= 1e-6f * (high - low).norm())
            return {fmt::format("{}.position: the camera sits in its target, {}{}, and looks nowhere", key, point(view.target), when)};
        if (ahead.normalized().cross(view.up.normalized()).norm() < 1e-4f)
            return {fmt::format("{}.up: the camera looks along what is up in the picture, {}{}: take another direction", key,
                                point(view.up), when)};
        const std::string target = key + (camera.kind == "auto" ? ".min" : ".target");
        const std::string position = key + (camera.kind == "auto" ? ".min" : ".position");
        const Seen seen = seen_from(view, aspect, low, high);
        const float away = (middle - view.position).norm();
        if (!seen.any)
            return {fmt::format("{}: the camera at {} looks past the whole domain{}; {} is its middle", target, point(view.position), when,
                                point(middle))};
        if (seen.part < least_part)
            return {fmt::format("{}: the domain is {:.2g} % of the picture's height, the camera is {:.3g} m away{}; lengths are in metres",
                                position, 100 * seen.part, away, when)};
    }
    return {};
}

Plan make_plan(const SceneFile& file) {
    Plan plan = make_plan(file.scene);
    for (std::string& warning : camera_warnings(file)) plan.warnings.push_back(std::move(warning));
    return plan;
}

}  // namespace whorl

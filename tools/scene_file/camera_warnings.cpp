#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/scene/scene.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

constexpr double least_part = 0.02;  ///< least diameter of the domain without a warning, as a part of the image's height

std::string point(const Vec3f& x) { return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", x.x(), x.y(), x.z()); }

/// Diameter of the sphere around a box, divided by the height of the image; 0 if the sphere is outside the image.
double part_of_picture(const View& view, double aspect, const Vec3d& low, const Vec3d& high) {
    const Vec3d ahead = (view.target - view.position).cast<double>().normalized(), to = 0.5 * (low + high) - view.position.cast<double>();
    const double radius = 0.5 * (high - low).norm(), away = to.norm();
    if (away <= radius) return 1;
    const double tall = std::tan(0.5 * static_cast<double>(view.fov) * std::numbers::pi / 180);
    const double aside = std::acos(std::clamp(to.dot(ahead) / away, -1.0, 1.0));
    return aside > std::atan(tall * std::hypot(1, aspect)) + std::asin(radius / away) ? 0 : radius / (away * tall);
}

}  // namespace

std::vector<std::string> camera_warnings(const SceneFile& file) {
    if (!file.scene.output.images || (file.camera.kind == "auto" && !file.camera.min)) return {};
    const CameraOptions& camera = file.camera;
    const Scene& scene = file.scene;
    std::vector<double> times{0, 0.5 * scene.time.end, scene.time.end};
    const bool still = camera.kind == "fixed" || camera.kind == "auto";
    if (still) times = {0};
    for (const CameraKey& key : camera.keys)
        if (camera.kind == "keys" && key.time <= scene.time.end) times.push_back(key.time);
    const Vec3f low = scene.domain.min.cast<float>(), high = scene.domain.max.cast<float>(), middle = 0.5f * (low + high);
    const double aspect = static_cast<double>(scene.output.size[0]) / scene.output.size[1];
    for (const double time : times) {
        const View view = view_at(camera, time, low, high);
        const std::string when = still ? "" : fmt::format(" at {:g} s", time);
        const Vec3f ahead = view.target - view.position;
        if (ahead.norm() <= 1e-6f * (high - low).norm())
            return {fmt::format("camera: its position is its target, {}{}", point(view.target), when)};
        if (ahead.normalized().cross(view.up.normalized()).norm() < 1e-4f)
            return {fmt::format("camera.up = {}: the camera looks along it{}; set another direction", point(view.up), when)};
        const double part = part_of_picture(view, aspect, scene.domain.min, scene.domain.max);
        if (part == 0)
            return {fmt::format("camera: from {} it does not see the domain{}; the centre of the domain is {}", point(view.position), when,
                                point(middle))};
        if (part < least_part)
            return {
                fmt::format("camera: the domain covers {:.2g} % of the image's height, seen from {:.3g} m away{}; lengths are in metres",
                            100 * part, (middle - view.position).norm(), when)};
    }
    return {};
}

Plan make_plan(const SceneFile& file) {
    Plan plan = make_plan(file.scene);
    for (std::string& warning : camera_warnings(file)) plan.warnings.push_back(std::move(warning));
    return plan;
}

}  // namespace whorl

#include "tools/scene_file/camera_warnings.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/scene/scene.h"

namespace whorl {
namespace {

constexpr double least_part = 0.02;  ///< of the picture's height that the domain should take

std::string point(const Vec3f& x) { return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", x.x(), x.y(), x.z()); }

/// The larger side of a box in the picture over the picture's height; 0: no corner is in the picture, and no ray through it meets the box.
double part_of_picture(const View& view, double aspect, const Vec3d& low, const Vec3d& high) {
    const Vec3d position = view.position.cast<double>(), ahead = (view.target - view.position).cast<double>().normalized();
    const Vec3d side = ahead.cross(view.up.cast<double>()).normalized(), above = side.cross(ahead);
    const double tall = std::tan(0.5 * static_cast<double>(view.fov) * std::numbers::pi / 180);
    const Eigen::AlignedBox3d box(low - position, high - position);
    Eigen::AlignedBox2d seen;
    bool any = false, behind = false;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d x = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
        const double far = tall * x.dot(ahead);
        if (far <= 0) {
            behind = true;
            continue;
        }
        const Eigen::Vector2d at(x.dot(side) / far, x.dot(above) / far);
        seen.extend(at), any = any || (std::abs(at.x()) <= aspect && std::abs(at.y()) <= 1);
    }
    constexpr int rays = 16;  // along each axis of the picture
    for (int k = 0; !any && k <= rays * rays; ++k) {
        const double u = 2.0 * (k % rays) / (rays - 1) - 1, v = 2.0 * (k / rays) / rays - 1;
        const Vec3d inverse = (ahead + tall * (aspect * u * side + v * above)).cwiseInverse();
        const Vec3d a = box.min().cwiseProduct(inverse), b = box.max().cwiseProduct(inverse);
        any = std::max(0.0, a.cwiseMin(b).maxCoeff()) <= a.cwiseMax(b).minCoeff();
    }
    return !any ? 0 : behind ? 1 : 0.5 * seen.sizes().maxCoeff();
}

/// Names of the keys for the camera's position, target and up direction.
struct CameraNames {
    std::string position = "camera.position", target = "camera.target", up = "camera.up", fov = "camera.fov";
};
CameraNames names_of(const CameraOptions& camera, double time) {
    CameraNames names;
    if (camera.kind == "auto") names.position = names.target = "camera.min";
    if (camera.kind == "orbit") names.position = "camera.distance";
    if (camera.kind != "keys" || camera.keys.empty()) return names;
    const auto far = [&](const CameraKey& key) { return std::abs(key.time - time); };
    const auto nearest =
        std::min_element(camera.keys.begin(), camera.keys.end(), [&](const auto& a, const auto& b) { return far(a) < far(b); });
    const std::string key = fmt::format("camera.key[{}]", nearest - camera.keys.begin());
    names.position = key + ".position", names.target = key + ".target", names.fov = key + ".fov";
    return names;
}

/// A lens that is too narrow or too wide for what is ahead.
void warn_of_lens(const SceneFile& file, const View& view, const std::string& fov, const std::string& when,
                  std::vector<std::string>& warnings) {
    const auto wide = static_cast<double>(view.fov), ahead = static_cast<double>((view.target - view.position).norm());
    const double seen = 2 * ahead * std::tan(0.5 * wide * std::numbers::pi / 180),
                 room = (file.scene.domain.max - file.scene.domain.min).maxCoeff();
    if (wide < 1 && seen < 0.1 * room)
        warnings.push_back(
            fmt::format("{} = {:g}: {:.2g} m of the scene are in the picture's height{}; it is in degrees, and the camera "
                        "is {:.3g} m away",
                        fov, wide, seen, when, ahead));
    if (const auto lens = static_cast<double>(view.aperture), focus = static_cast<double>(view.focus); lens > 0.5 * focus)
        warnings.push_back(
            fmt::format("camera.aperture = {:g}: such a wide lens blurs all but what is just {:.3g} m away{}; it is in metres, and "
                        "{:g} mm would be {:g}",
                        lens, focus, when, lens, lens / 1000));
}

/// Keys of the camera that make it jump, or that the film does not reach. A quick look with an earlier end is no mistake.
void warn_of_keys(const SceneFile& file, std::vector<std::string>& warnings) {
    const std::vector<CameraKey>& keys = file.camera.keys;
    if (file.camera.kind != "keys") return;
    const double end = file.scene.time.end;
    bool late = file.scene.place("time.end").line == 0;  // no more is said of it
    for (std::size_t i = 0; i < keys.size(); ++i) {
        if (keys[i].time > end && !late) {
            warnings.push_back(fmt::format("camera.key[{}].time = {:g} s is after the film's end, {:g} s", i, keys[i].time, end));
            late = true;
        }
        for (std::size_t j = 0; j < i; ++j)
            if (keys[i].time == keys[j].time) {
                warnings.push_back(
                    fmt::format("camera.key[{}] has the time of camera.key[{}], {:g} s: there the camera jumps", i, j, keys[i].time));
                break;
            }
    }
}

std::vector<std::string> view_warnings(const SceneFile& file) {
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
        const CameraNames name = names_of(camera, time);
        const std::string when = still ? "" : fmt::format(" at {:g} s", time);
        const Vec3f ahead = view.target - view.position;
        if (ahead.norm() <= 1e-6f * (high - low).norm())
            return {fmt::format("{}: the camera sits in its target, {}{}, and looks nowhere", name.position, point(view.target), when)};
        if (ahead.normalized().cross(view.up.normalized()).norm() < 1e-4f)
            return {fmt::format("{}: the camera looks along what is up in the picture, {}{}: take another direction", name.up,
                                point(view.up), when)};
        const double part = part_of_picture(view, aspect, scene.domain.min, scene.domain.max);
        const float away = (middle - view.position).norm();
        if (part == 0)
            return {fmt::format("{}: the camera at {} looks past the whole domain{}; {} is its middle", name.target, point(view.position),
                                when, point(middle))};
        if (part < least_part)
            return {fmt::format("{}: the domain is {:.2g} % of the picture's height, the camera is {:.3g} m away{}; lengths are in metres",
                                name.position, 100 * part, away, when)};
        std::vector<std::string> of_lens;
        if (camera.kind != "auto") warn_of_lens(file, view, name.fov, when, of_lens);
        if (!of_lens.empty()) return of_lens;
    }
    return {};
}

}  // namespace

std::vector<std::string> camera_warnings(const SceneFile& file) {
    if (!file.scene.output.frames || (file.camera.kind == "auto" && !file.camera.min)) return {};
    std::vector<std::string> warnings = view_warnings(file);
    warn_of_keys(file, warnings);
    return warnings;
}

Plan make_plan(const SceneFile& file) {
    Plan plan = make_plan(file.scene);
    for (std::string& warning : camera_warnings(file)) plan.warnings.push_back(std::move(warning));
    return plan;
}

}  // namespace whorl

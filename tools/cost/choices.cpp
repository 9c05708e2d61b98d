#include "tools/cost/choices.h"

#include <algorithm>
#include <cmath>

#include "engine/io/snapshot.h"
#include "engine/scene/scene_scales.h"
#include "render/flow/marks.h"
#include "render/flow/slice.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"

namespace whorl {
namespace {

/// Colour range from 0 to `high` rounded up; from -high to high on a diverging map. @param high in the unit of the field
std::array<float, 2> range_up_to(double high, const LookOptions& look) {
    const auto round = static_cast<float>(high > 0 && std::isfinite(high) ? round_number_above(high) : 1);
    return {is_diverging(look.colour_map) ? -round : 0.0f, round};
}

/// Colour range estimated from the scene. U is the largest expected speed. The upper end is U for the speed, the larger of the initial
/// maximum and density U^2/2 for the pressure, and 1 for ink. Other fields are rates: the initial maximum, or U/(8 spacings) if that is 0.
std::array<float, 2> estimated_range(const LookOptions& look, const Simulation& start) {
    if (look.field == "ink") return range_up_to(1, look);
    const Scene& scene = start.scene();
    double first = 0;
    for (const float v : field_values(Snapshots(start, {look.field}).take(start, 1), look))
        if (std::isfinite(v)) first = std::max(first, static_cast<double>(std::abs(v)));
    const double speed = start.plan().expected_speed;
    if (look.field == "speed") return range_up_to(speed, look);
    if (look.field == "pressure") return range_up_to(std::max(first, 0.5 * scene.fluid.density * speed * speed), look);
    return range_up_to(first > 0 ? first : speed / (8 * scene.fluid.spacing), look);
}

std::array<float, 2> range_of_temperatures(const Scene& scene) {
    const auto [coldest, warmest] = temperature_range(scene);
    return {static_cast<float>(std::floor(coldest)), static_cast<float>(std::max(std::ceil(warmest), std::floor(coldest) + 1))};
}

/// streak_time for a scene that leaves it open [s].
float estimated_streak_time(const LookOptions& look, const Simulation& simulation) {
    const Scene& scene = simulation.scene();
    const double size = (scene.domain.max - scene.domain.min).maxCoeff();
    const double speed = simulation.plan().expected_speed;
    if (!(speed > 0)) return 0;
    if (!look.streaks) return static_cast<float>(arrow_reach * size / look.arrows / speed);
    return static_cast<float>(std::clamp(scene.time.frame_interval(), size / 45 / speed, size / 16 / speed));
}

}  // namespace

bool measures_range(const LookOptions& look) {
    return wants_range(look) && look.field != "density" && look.field != "ink" && look.field != "temperature";
}

void choose(SceneFile& file, const SeenBox& extent, float size) {
    if (wants_extent(file)) look_at(file.camera, extent);
    if (!wants_range(file.look)) return;
    const auto rest = static_cast<float>(file.scene.fluid.density);
    if (file.look.field == "density") file.look.range = {0.97f * rest, 1.03f * rest};
    else if (file.look.field == "temperature") file.look.range = range_of_temperatures(file.scene);
    else if (measures_range(file.look) && size > 0) file.look.range = range_up_to(size, file.look);
}

SceneFile with_estimates(SceneFile file, const Simulation& start) {
    choose(file, {}, 0);
    if (wants_range(file.look)) file.look.range = estimated_range(file.look, start);
    if (wants_extent(file)) look_at(file.camera, foreseen_extent(start));
    if (wants_streak_time(file.look)) file.look.streak_time = estimated_streak_time(file.look, start);
    return file;
}

double round_number_above(double value) {
    const double magnitude = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (value <= factor * magnitude * (1 + 1e-6)) return factor * magnitude;
    return 10 * magnitude;
}

bool wants_range(const LookOptions& look) { return shows_field(look) && look.range[0] == look.range[1]; }

bool wants_streak_time(const LookOptions& look) {
    return look.style == "slice" && (look.streaks || look.arrows > 0) && !(look.streak_time > 0);
}

namespace {

SeenBox domain_of(const Frame& frame) { return {frame.domain_min, frame.domain_max}; }

/// Extends the box by the part of another one that lies in the domain.
void extend_inside(SeenBox& extent, const SeenBox& part, const SeenBox& domain) {
    const SeenBox inside = part.intersection(domain);
    if (!inside.isEmpty()) extent.extend(inside);
}

/// Box between the 0.5th and 99.5th percentile of the positions along each axis, plus half a spacing on every side.
SeenBox usual_extent(const std::vector<Vec3f>& position, float spacing) {
    std::vector<float> along;
    Vec3f low, high;
    for (int a = 0; a < 3; ++a) {
        along.clear();
        for (const Vec3f& x : position)
            if (x.allFinite()) along.push_back(x[a]);
        if (along.empty()) return {};
        const auto rare = static_cast<std::ptrdiff_t>(along.size() / 200);
        std::nth_element(along.begin(), along.begin() + rare, along.end());
        low[a] = along[static_cast<std::size_t>(rare)];
        std::nth_element(along.begin(), along.end() - 1 - rare, along.end());
        high[a] = *(along.end() - 1 - rare);
    }
    return {low - Vec3f::Constant(0.5f * spacing), high + Vec3f::Constant(0.5f * spacing)};
}

SeenBox opening(const FrameEmitter& e) {
    const Vec3f across = 0.5f * e.width * e.width_axis, other = 0.5f * e.thickness * e.direction.cross(e.width_axis);
    SeenBox extent;
    for (const float s : {-1.0f, 1.0f})
        for (const float t : {-1.0f, 1.0f}) extent.extend(e.position + s * across + t * other);
    return extent;
}

SeenBox of_solid(const TriangleMesh& mesh, const Mat3f& rotation, const Vec3f& translation) {
    SeenBox extent;
    for (const Vec3f& x : mesh.position) extent.extend(rotation * x + translation);
    return extent;
}

/// Follows a point released at x [m] with velocity u [m/s] in free fall, to a solid, a side of the domain or the end of the run.
/// @return its last position inside the domain [m]
Vec3d landing(const Simulation& start, Vec3d x, Vec3d u) {
    const Scene& scene = start.scene();
    const Vec3d g = scene.domain.gravity(0);
    const double far = (scene.domain.max - scene.domain.min).maxCoeff() / 100, near = std::min(far, start.plan().spacing);
    double reach = near;  // bound for the next step: not beyond the nearest solid
    for (double left = scene.time.end; left > 0;) {
        const double speed = std::max(u.norm(), std::sqrt(g.norm() * reach));
        if (!(speed > 0)) break;
        const double dt = std::min(left, 0.5 * reach / speed);  // so the displacement dt (u + dt g) is at most 3/4 of reach
        u += dt * g;
        const Vec3d next = x + dt * u;
        left -= dt;
        if ((next.array() < scene.domain.min.array()).any() || (next.array() > scene.domain.max.array()).any()) break;
        x = next;
        Real clear = 0;
        const bool any = start.world().solids.nearest(x.cast<Real>(), clear) >= 0;
        if (any && clear < 0) break;
        reach = any ? std::clamp(static_cast<double>(clear), near, far) : far;
    }
    return x;
}

SeenBox around(const Vec3d& x, const Vec3d& reach) { return {(x - reach).cast<float>(), (x + reach).cast<float>()}; }

/// Extends the box by each solid that intersects it, unless its longest edge would then exceed 1.5 times the original one. So the plate
/// under honey is shown completely, a floor is not. @param frame first frame
void add_still_solids(SeenBox& extent, const Frame& frame) {
    constexpr float most = 1.5f;
    const SeenBox domain = domain_of(frame);
    const float size = extent.isEmpty() ? 0 : extent.sizes().maxCoeff();
    for (const FrameSolid& solid : frame.solids) {
        if (!solid.mesh || solid.ground) continue;
        const SeenBox own = of_solid(*solid.mesh, solid.rotation, solid.translation).intersection(domain);
        if (own.isEmpty() || !own.intersects(extent) || extent.merged(own).sizes().maxCoeff() > most * size) continue;
        extent.extend(own);
    }
}

}  // namespace

void add_seen(SeenBox& extent, const Frame& frame, const Frame& start) {
    const auto add = [&](const SeenBox& part) { extend_inside(extent, part, domain_of(frame)); };
    add(usual_extent(frame.position, frame.spacing));
    for (const FrameEmitter& e : frame.emitters) add(opening(e));
    for (std::size_t k = 0; k < std::min(frame.solids.size(), start.solids.size()); ++k) {
        const FrameSolid &now = frame.solids[k], &then = start.solids[k];
        if (!now.mesh || !then.mesh || now.ground || (now.rotation == then.rotation && now.translation == then.translation)) continue;
        add(of_solid(*now.mesh, now.rotation, now.translation));
        add(of_solid(*then.mesh, then.rotation, then.translation));
    }
}

void Seen::add(const Frame& frame) {
    if (!start_) start_ = frame;
    if (shows_field(look_)) size_ = std::max(size_, usual_size(field_values(frame, look_)));
    add_seen(extent_, frame, *start_);
}

SeenBox Seen::extent() const {
    SeenBox all = extent_;
    if (start_) add_still_solids(all, *start_);
    return all;
}

SeenBox foreseen_extent(const Simulation& start) {
    const Scene& scene = start.scene();
    const World& world = start.world();
    const Frame frame = Snapshots(start, {}).take(start, 1);
    SeenBox extent;
    const auto add = [&](const SeenBox& part) { extend_inside(extent, part, domain_of(frame)); };
    add_seen(extent, frame, frame);

    const Vec3d g = scene.domain.gravity(0), down = g.norm() > 0 ? Vec3d(g / g.norm()) : Vec3d::Zero();
    const double edge = std::pow(start.plan().estimated_particles, 1.0 / scene.domain.dimensions) * start.plan().spacing;
    const Vec3d spread = g.norm() > 0 ? Vec3d(edge * (Vec3d::Ones() - down.cwiseAbs())) : Vec3d::Zero();
    const std::size_t stride = std::max<std::size_t>(1, frame.position.size() / 64);
    for (std::size_t i = 0; i < frame.position.size(); i += stride)
        add(around(landing(start, frame.position[i].cast<double>(), frame.velocity[i].cast<double>()), spread));
    constexpr int moments = 24;
    for (const EmitterKeys& e : scene.emitters)
        for (int n = 0; n <= moments; ++n)
            if (const double t = n * scene.time.end / moments; t >= e.start && t <= e.stop)
                add(around(landing(start, e.position(t), e.speed(t) * e.direction(t).normalized()), spread));

    Solids solids;
    solids.all = world.solids.all;
    for (int n = 0; n <= moments; ++n) {
        solids.set_time(n * scene.time.end / moments, scene.time.end / moments);
        for (std::size_t k = 0; k < solids.all.size(); ++k) {
            const FrameSolid& drawn = frame.solids[k];
            if (drawn.ground || !solids.all[k].moves()) continue;
            const Pose& pose = solids.all[k].pose;
            add(of_solid(*drawn.mesh, pose.rotation.cast<float>(), pose.translation.cast<float>()));
        }
    }
    add_still_solids(extent, frame);
    return extent;
}

bool wants_extent(const SceneFile& file) { return file.camera.kind == "auto" && !file.camera.min && file.look.style != "slice"; }

void look_at(CameraOptions& camera, const SeenBox& extent) {
    if (extent.isEmpty()) return;
    const double size = extent.sizes().cast<double>().maxCoeff(), step = std::pow(10.0, std::floor(std::log10(size)) - 2);
    Vec3f low, high;
    for (int a = 0; a < 3; ++a) {
        low[a] = static_cast<float>(std::floor(static_cast<double>(extent.min()[a]) / step + 1e-3) * step);
        high[a] = static_cast<float>(std::ceil(static_cast<double>(extent.max()[a]) / step - 1e-3) * step);
    }
    camera.min = low, camera.max = high;
}

}  // namespace whorl

#include "tools/film/film_extent.h"

#include <algorithm>
#include <cmath>

#include "engine/io/snapshot.h"

namespace whorl {
namespace {

Extent domain_of(const Frame& frame) { return {frame.domain_min, frame.domain_max}; }

/// Grows by the part that lies in the domain.
void extend_inside(Extent& extent, const Extent& part, const Extent& domain) {
    const Extent inside = part.intersection(domain);
    if (!inside.isEmpty()) extent.extend(inside);
}

/// What lies between the lowest and the highest half per cent along each axis, with the room of a particle.
Extent usual_extent(const std::vector<Vec3f>& position, float spacing) {
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

Extent opening(const FrameEmitter& e) {
    const Vec3f across = 0.5f * e.width * e.width_axis, other = 0.5f * e.thickness * e.direction.cross(e.width_axis);
    Extent extent;
    for (const float s : {-1.0f, 1.0f})
        for (const float t : {-1.0f, 1.0f}) extent.extend(e.position + s * across + t * other);
    return extent;
}

Extent of_solid(const TriangleMesh& mesh, const Mat3f& rotation, const Vec3f& translation) {
    Extent extent;
    for (const Vec3f& x : mesh.position) extent.extend(rotation * x + translation);
    return extent;
}

/// Follows what is let go at x with velocity u through a free fall, until a solid or the domain's end stops it or the film is over.
/// @return where it was last inside the domain
Vec3d landing(const Simulation& start, Vec3d x, Vec3d u) {
    const Scene& scene = start.scene();
    const Vec3d g = scene.domain.gravity(0);
    const double far = (scene.domain.max - scene.domain.min).maxCoeff() / 100, near = std::min(far, start.plan().spacing);
    double reach = near;  // of the next step: never beyond the nearest solid
    for (double left = scene.time.end; left > 0;) {
        const double speed = std::max(u.norm(), std::sqrt(g.norm() * reach));
        if (!(speed > 0)) break;
        const double dt = std::min(left, 0.5 * reach / speed);  // with what g adds: at most 3/4 of the reach
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

Extent around(const Vec3d& x, const Vec3d& reach) { return {(x - reach).cast<float>(), (x + reach).cast<float>()}; }

}  // namespace

void add_still_solids(Extent& extent, const Frame& frame) {
    constexpr float most = 1.5f;
    const Extent domain = domain_of(frame);
    const float size = extent.isEmpty() ? 0 : extent.sizes().maxCoeff();
    for (const FrameSolid& solid : frame.solids) {
        if (!solid.mesh || solid.ground) continue;
        const Extent own = of_solid(*solid.mesh, solid.rotation, solid.translation).intersection(domain);
        if (own.isEmpty() || !own.intersects(extent) || extent.merged(own).sizes().maxCoeff() > most * size) continue;
        extent.extend(own);
    }
}

void add_seen(Extent& extent, const Frame& frame, const Frame& start) {
    const auto add = [&](const Extent& part) { extend_inside(extent, part, domain_of(frame)); };
    add(usual_extent(frame.position, frame.spacing));
    for (const FrameEmitter& e : frame.emitters) add(opening(e));
    for (std::size_t k = 0; k < std::min(frame.solids.size(), start.solids.size()); ++k) {
        const FrameSolid &now = frame.solids[k], &then = start.solids[k];
        if (!now.mesh || !then.mesh || now.ground || (now.rotation == then.rotation && now.translation == then.translation)) continue;
        add(of_solid(*now.mesh, now.rotation, now.translation));
        add(of_solid(*then.mesh, then.rotation, then.translation));
    }
}

Extent foreseen_extent(const Simulation& start) {
    const Scene& scene = start.scene();
    const World& world = start.world();
    const Frame frame = Snapshots(start, {}).take(start, 1);
    Extent extent;
    const auto add = [&](const Extent& part) { extend_inside(extent, part, domain_of(frame)); };
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
                add(around(landing(start, e.position, e.speed(t) * e.direction), spread));

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

void look_at(CameraOptions& camera, const Extent& extent) {
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

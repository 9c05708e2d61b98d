#include "engine/scene/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// The fastest that a solid's surface moves, from its expressions.
double solid_speed(const SolidKeys& solid, const Extent& extent, double end) {
    if (!solid.position.depends_on_time() && solid.rotation.is_zero()) return 0;
    const double reach = 0.5 * (extent.max - extent.min).norm();  // it turns about its middle
    double most = 0;
    const double dt = 1e-4 * end;
    for (const double t : sample_times(0, end)) {
        const Vec3d velocity = (solid.position(t + dt) - solid.position(t)) / dt;
        const double turning = solid.rotation(t).norm() * (std::isfinite(reach) ? reach : 0);
        most = std::max(most, velocity.norm() + turning);
    }
    return most;
}

/// Calls f at 5 x 5 x 5 points from corner to corner.
template <class F>
void over_box(const Vec3d& min, const Vec3d& max, F&& f) {
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            for (int k = 0; k < 5; ++k) f(Vec3d(min + 0.25 * Vec3d(i, j, k).cwiseProduct(max - min)));
}

}  // namespace

std::vector<double> sample_times(double from, double to) {
    std::vector<double> times;
    for (int k = 0; k <= 256; ++k) times.push_back(from + (to - from) * k / 256);
    return times;
}

double opening_area(const EmitterKeys& e) { return e.shape == "disc" ? std::numbers::pi * e.radius * e.radius : e.width * e.thickness; }

double emitted_volume(const EmitterKeys& e, double end) {
    const double stop = std::min(e.stop, end);
    if (!(stop > e.start)) return 0;
    double sum = 0;
    const std::vector<double> times = sample_times(e.start, stop);
    for (std::size_t k = 0; k + 1 < times.size(); ++k)
        sum += 0.5 * (std::max(0.0, e.speed(times[k])) + std::max(0.0, e.speed(times[k + 1]))) * (times[k + 1] - times[k]);
    return sum * opening_area(e);
}

SceneNumbers scene_numbers(const Scene& scene, const SceneShapes& shapes, double support) {
    SceneNumbers n;
    const double d = n.spacing = scene.fluid.spacing, end = scene.time.end;
    n.free_surface = !(scene.domain.periodic[0] && scene.domain.periodic[1] && scene.domain.periodic[2]);

    Vec3d pull = Vec3d::Zero();
    for (const double t : sample_times(0, end)) {
        const Vec3d g = scene.domain.gravity(t);
        if (g.norm() > n.gravity) n.gravity = g.norm(), pull = g;
    }
    // Height over the floor: along -gravity, from the domain's lowest corner.
    const Vec3d up = n.gravity > 0 ? Vec3d(-pull / n.gravity) : Vec3d::Zero();
    const auto height = [&](const Vec3d& low, const Vec3d& high) {
        double top = 0;
        for (int a = 0; a < 3; ++a) {
            if (scene.domain.periodic[a]) continue;
            const double floor = up[a] > 0 ? scene.domain.min[a] : scene.domain.max[a];
            top += up[a] * ((up[a] > 0 ? high[a] : low[a]) - floor);
        }
        return std::max(0.0, top);
    };

    n.across = n.least_viscosity = std::numeric_limits<double>::infinity();
    const auto thin = [&](double length, const std::string& name) {
        if (length / d < n.across) n.across = length / d, n.thinnest = name;
    };
    const auto viscous = [&](std::size_t source, const Vec3d& x) {
        const Expression& mu = scene.viscosity_of_source(source);
        n.viscosity = std::max(n.viscosity, mu(0, x));
        if (mu(0, x) < n.least_viscosity) {
            n.least_viscosity = mu(0, x);
            n.thinnest_fluid =
                source > 0 && scene.emitters[source - 1].viscosity ? entry_name("emitter", source - 1) + ".viscosity" : "fluid.viscosity";
        }
        if (depends_on_age(mu))
            for (const double age : sample_times(0, end)) n.viscosity = std::max(n.viscosity, mu(age, x));
    };

    for (std::size_t i = 0; i < scene.blocks.size(); ++i) {
        const BlockKeys& block = scene.blocks[i];
        const Extent& e = shapes.block_extent[i];
        const Vec3d low = e.min.cwiseMax(scene.domain.min), high = e.max.cwiseMin(scene.domain.max);
        over_box(low, high, [&](const Vec3d& x) {
            n.speed = std::max(n.speed, block.velocity(0, x).norm());
            viscous(0, x);
        });
        n.particles += e.volume / (d * d * d);
        n.fall = std::max(n.fall, height(low, high));
        Vec3d size = e.max - e.min;
        for (int a = 0; a < 3; ++a)  // a film along a periodic axis is endless, not thin
            if (scene.domain.periodic[a] && size[a] > 0.999 * (scene.domain.max[a] - scene.domain.min[a]))
                size[a] = std::numeric_limits<double>::infinity();
        if (std::isfinite(size.minCoeff())) thin(size.minCoeff(), entry_name("block", i));
    }
    for (std::size_t i = 0; i < scene.emitters.size(); ++i) {
        const EmitterKeys& e = scene.emitters[i];
        const double peak = e.profile == Profile::parabolic ? (e.shape == "disc" ? 2 : 2.25) : 1;
        for (const double t : sample_times(e.start, std::max(e.start, std::min(e.stop, end))))
            n.speed = std::max(n.speed, peak * e.speed(t));
        viscous(i + 1, e.position);
        n.particles += emitted_volume(e, end) / (d * d * d);
        n.fall = std::max(n.fall, height(e.position, e.position));
        thin(e.shape == "disc" ? 2 * e.radius : std::min(e.width, e.thickness), entry_name("emitter", i));
    }
    for (std::size_t i = 0; i < scene.solids.size(); ++i) {
        n.speed = std::max(n.speed, solid_speed(scene.solids[i], shapes.solid_extent[i], end));
        if (!shapes.solids.all[i].body) continue;
        n.speed = std::max(n.speed, scene.solids[i].velocity.norm());
        const Vec3d at = scene.solids[i].position(0);
        n.fall = std::max(n.fall, height(shapes.solid_extent[i].min + at, shapes.solid_extent[i].max + at));
    }

    n.speed = std::max(n.speed, std::sqrt(n.speed * n.speed + 2 * n.gravity * n.fall));
    n.nu = n.viscosity / scene.fluid.density;
    n.step = n.speed > 0 ? std::min(scene.time.max_step, scene.time.cfl * d / n.speed) : scene.time.max_step;
    if (scene.time.fixed_step > 0) n.step = scene.time.fixed_step;
    n.viscous_number = n.nu * n.step / (d * d);
    n.least_viscous_number = n.least_viscosity > 0 ? 0.4 * n.least_viscosity / (scene.fluid.density * n.speed * d) : 0;
    n.explicit_step = n.nu > 0 ? 0.125 * support * support / (4 * n.nu) : std::numeric_limits<double>::infinity();
    return n;
}

}  // namespace whorl

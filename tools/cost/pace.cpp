#include "tools/cost/pace.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/models/surface_tension/surface_tension.h"
#include "engine/scene/numbers.h"

namespace whorl {
namespace {

constexpr int points = 512;  ///< of time, for threads

/// Whether the fluid lies as a pool that fills its container from side to side: it cannot fall.
bool lies_as_a_pool(const Scene& scene, const SceneShapes& shapes, const Vec3d& low, const Vec3d& high, const Vec3d& mean) {
    const double d = scene.fluid.spacing, near = 2 * d;
    const Vec3d g = scene.domain.gravity(0);
    int axis = 0;
    g.cwiseAbs().maxCoeff(&axis);
    if (std::abs(g[axis]) < 0.99 * g.norm()) return false;
    if (std::abs(mean[axis] - 0.5 * (low[axis] + high[axis])) > 0.1 * (high[axis] - low[axis]) + 0.5 * d) return false;  // not as high everywhere
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {
        if (!scene.solids[k].inside) continue;
        const Extent& room = shapes.solid_extent[k];
        bool filled = true;
        for (int a = 0; a < 3; ++a) {
            if (a == axis || scene.domain.periodic[a]) continue;
            filled = filled && low[a] - room.min[a] < near && room.max[a] - high[a] < near;
        }
        const bool on_floor = g[axis] < 0 ? low[axis] - room.min[axis] < near : room.max[axis] - high[axis] < near;
        if (filled && on_floor) return true;
    }
    return false;
}

/// How far something can fall from x [m] before it meets a solid where that stands at the start; at most `most`.
double free_way(const Scene& scene, const Solids& solids, const Vec3d& x, double most) {
    const Vec3d g = scene.domain.gravity(0);
    if (g.norm() == 0) return 0;
    double way = 0;
    for (; way < most; way += scene.fluid.spacing) {
        Real distance = 0;
        const Vec3 at = Vec3d(x + way * g.normalized()).cast<Real>();
        if (solids.nearest(at, distance) >= 0 && distance <= 0) break;
    }
    return std::min(way, most);
}

/// Speed of the lower end of what an emitter lets out, at even times: it gets longer as fast as its end falls. A drop hangs on as long as surface tension
/// carries its weight, up to a length 2 sigma/(rho g a).
void add_thread(std::vector<double>& speeds, const EmitterKeys& e, const Scene& scene, double nu, double g, double fall) {
    const double dt = scene.time.end / (points - 1), a = std::sqrt(opening_area(e) / M_PI);
    const double held = g > 0 ? 2 * scene.fluid.surface_tension / (scene.fluid.density * g * a) : 0;
    double length = 0;
    for (int k = 0; k < points; ++k) {
        const double t = k * dt;
        if (t < e.start) continue;
        const double U = std::max(e.speed(t), 1e-9);
        const double pull = g * std::max(0.0, 1 - held / std::max(length, 1e-30));
        const double speed = length > 0 ? drawn_speed(U, length, pull, nu) : U;
        speeds[static_cast<std::size_t>(k)] = std::max(speeds[static_cast<std::size_t>(k)], speed);
        length = std::min(length + speed * dt, fall);
    }
}

}  // namespace

double drawn_speed(double U, double H, double g, double nu) {
    const double free = std::sqrt(U * U + 2 * g * H);
    if (nu <= 0 || free <= U * (1 + 1e-9)) return free;
    const double wanted = H * std::sqrt(g / (6 * nu));
    double low = U, high = U + g * H * H / (6 * nu);  // without the thinning, which makes it lighter
    for (int k = 0; k < 50; ++k) {
        const double u = 0.5 * (low + high);
        (std::sqrt(u) * (0.5 * M_PI - std::asin(std::sqrt(std::min(1.0, U / u)))) < wanted ? low : high) = u;
    }
    const double crept = high - U, fallen = free - U;
    return U + crept * fallen / (crept + fallen);
}

Pace::Pace(const Scene& scene, const Plan& plan, const Simulation& simulation)
    : scene_(scene), simulation_(simulation), threads_(static_cast<std::size_t>(points), 0.0) {
    std::vector<Problem> none;
    const SceneShapes shapes = make_shapes(scene, none);
    const SceneNumbers n = scene_numbers(scene, shapes, plan.support);
    given_ = std::sqrt(std::max(0.0, n.speed * n.speed - 2 * n.gravity * n.fall));
    gravity_ = n.gravity, free_ = n.speed;
    for (const EmitterKeys& e : scene.emitters) add_thread(threads_, e, scene, n.nu, n.gravity, free_way(scene, shapes.solids, e.position, n.fall));
    const bool implicit = plan.pressure == PressureModel::coupled || (plan.viscosity != ViscosityModel::none && plan.viscosity != ViscosityModel::xsph &&
                                                                      plan.viscosity != ViscosityModel::explicit_laplacian);
    if (scene.fluid.surface_tension > 0)
        tension_step_ = surface_tension_step(scene.fluid.density, plan.spacing, scene.fluid.surface_tension, implicit ? plan.largest_viscosity : 0);
    const World& world = simulation.world();
    const auto x = world.fluid.column<field::position>();
    if (world.fluid.size() == 0) return;
    const double inf = std::numeric_limits<double>::infinity();
    Vec3d low = Vec3d::Constant(inf), high = Vec3d::Constant(-inf), mean = Vec3d::Zero();
    for (Index i = 0; i < world.fluid.size(); ++i) {
        const Vec3d at = x[i].cast<double>();
        low = low.cwiseMin(at), high = high.cwiseMax(at), mean += at;
    }
    mean /= static_cast<double>(world.fluid.size());
    falls_ = n.gravity > 0 && !lies_as_a_pool(scene, shapes, low, high, mean);
    if (n.gravity > 0) pressing_ = std::sqrt(std::abs((high - low).dot(scene.domain.gravity(0))));
    if (n.nu > 0) creeping_ = given_ + n.gravity * n.fall * n.fall / (3 * n.nu);
}

double Pace::speed(double time) const {
    const double at = std::clamp(time / scene_.time.end, 0.0, 1.0) * (points - 1);
    double speed = std::max(given_, threads_[static_cast<std::size_t>(at)]);
    if (!falls_) return speed;
    const double fall = (free_ * free_ - given_ * given_) / (2 * gravity_), splashing = 6 * std::sqrt(2 * fall / gravity_);
    double block = std::min(free_, given_ + gravity_ * time);
    if (creeping_ > 0) block = std::min({block, 0.5 * free_, creeping_});
    else if (time > splashing) block *= 0.5;
    return std::max(speed, block);
}

double Pace::step(double time) const {
    const double u = speed(time);
    double dt = scene_.time.frame_interval();
    if (scene_.time.fixed_step > 0) return std::min(dt, scene_.time.fixed_step);
    for (const StepLimit& limit : simulation_.assembly().limits) {
        const bool unborn = limit.name == "surface tension" && simulation_.world().fluid.size() == 0;  // it asks the particles how viscous they are
        const double allowed = unborn ? tension_step_ : limit.dt(simulation_.world(), u);
        if (allowed > 0) dt = std::min(dt, allowed);
        // What will press is not known before the first solve: a column as high as the fluid is.
        if (limit.name == "pressure" && pressing_ > 0) dt = std::min(dt, scene_.time.cfl * scene_.fluid.spacing / pressing_);
    }
    return dt;
}

}  // namespace whorl

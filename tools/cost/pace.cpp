#include "tools/cost/pace.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/models/surface_tension/surface_tension.h"
#include "engine/scene/numbers.h"
#include "engine/theory/falling_thread.h"

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
    if (std::abs(mean[axis] - 0.5 * (low[axis] + high[axis])) > 0.1 * (high[axis] - low[axis]) + 0.5 * d)
        return false;  // not as high everywhere
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
    for (int k = 0; k < 10000 && way < most; ++k) {
        Real distance = 0;
        const Vec3 at = Vec3d(x + way * g.normalized()).cast<Real>();
        if (solids.nearest(at, distance) < 0) return most;
        if (distance <= 0) return way;
        // As far as no solid is; whole spacings, so that the way is one.
        way += scene.fluid.spacing * std::max(1.0, std::floor(static_cast<double>(distance) / scene.fluid.spacing));
    }
    return most;
}

/// What an emitter lets out, until its lower end lands: slices, each of which carries what left before it, less what surface tension holds:
///   da/dt = -(g/(3 nu)) (V - h sqrt a),   V: volume below over the opening's area A,   h = 2 sigma/(rho g sqrt(A/pi)),   a = area/A
/// (Trouton 1906, of slices as Wilson 1988 has them for dripping; no inertia but that the lower end gains no more than g). Where it gets
/// thinner than a spacing it parts: what hung there falls freely as a drop, the rest hangs on.
class HangingThread {
public:
    HangingThread(const EmitterKeys& e, const Scene& scene, double nu, double g) : nu_(nu), g_(g) {
        const int D = scene.domain.dimensions;
        const double radius = D == 2 ? narrowest_of(e, D) / 2 : std::sqrt(opening_area(e, D) / M_PI);
        if (g > 0) held_ = 2 * scene.fluid.surface_tension / (scene.fluid.density * g * radius);
        parted_ = std::min(0.9, std::pow(0.5 * scene.fluid.spacing / radius, 2));
    }
    double length() const { return length_; }  ///< m
    double held() const { return held_; }      ///< m of thread as thick as the opening
    /// Lets dt [s] pass while the fluid leaves with U [m/s]. @return m/s, of the lower end or of a drop that has not fallen as far as
    /// `fall` [m]
    double advance(double U, double dt, double fall) {
        stretch(U, dt);
        slices_.push_back({U * dt});
        part(U);
        if (drop_fallen_ < fall) drop_speed_ += g_ * dt, drop_fallen_ += drop_speed_ * dt;
        return drop_fallen_ < fall ? std::max(speed_, drop_speed_) : speed_;
    }

private:
    struct Slice {
        double volume = 0;  ///< over the opening's area [m]
        double area = 1;    ///< over the opening's
        double longer = 0;  ///< 1/area after its weight alone, less that before
    };

    void stretch(double U, double dt) {
        constexpr double thinnest = 1e-6;
        double below = 0, longer = 0;
        for (Slice& s : slices_) {
            const double carried = below - held_ * std::sqrt(s.area);
            below += s.volume;
            const double area = carried <= 0 ? s.area : nu_ > 0 ? std::max(thinnest, s.area - g_ / (3 * nu_) * carried * dt) : thinnest;
            s.longer = std::max(0.0, 1 / area - 1 / s.area);
            longer += s.volume * s.longer;
        }
        const double before = std::max(speed_, U);
        speed_ = std::min(U + longer / dt, before + g_ * dt);
        const double part = longer > 0 ? (speed_ - U) * dt / longer : 0;
        for (Slice& s : slices_) s.area = 1 / (1 / s.area + part * s.longer);
    }

    void part(double U) {
        const auto last = std::find_if(slices_.rbegin(), slices_.rend(), [&](const Slice& s) { return s.area < parted_; });
        if (last != slices_.rend()) {
            drop_speed_ = speed_, drop_fallen_ = length_, speed_ = U;
            slices_.erase(slices_.begin(), last.base());
        }
        length_ = 0;
        for (const Slice& s : slices_) length_ += s.volume / s.area;
    }

    double nu_, g_, held_ = 0, parted_ = 0;
    std::vector<Slice> slices_;  ///< the first left first
    double length_ = 0, speed_ = 0;
    double drop_speed_ = 0, drop_fallen_ = std::numeric_limits<double>::infinity();
};

/// Speed of the fastest of what an emitter lets out, at even times: of the end that hangs and of drops, and once the end has reached down
/// to `fall` that of a steady thread.
void add_thread(std::vector<double>& speeds, const EmitterKeys& e, const Scene& scene, double nu, double g, double fall) {
    const double dt = scene.time.end / (points - 1);
    HangingThread thread(e, scene, nu, g);
    for (int k = 0; k < points; ++k) {
        const double t = k * dt;
        if (t < e.start) continue;
        const double U = std::max(e.speed(t), 1e-9);
        const double speed = thread.length() < fall
                                 ? std::min(thread.advance(U, dt, fall), std::sqrt(U * U + 2 * g * fall))
                                 : fast_end_speed({U, fall, g * std::max(0.0, 1 - thread.held() / std::max(fall, 1e-30)), nu});
        speeds[k] = std::max(speeds[k], speed);
    }
}

}  // namespace

Pace::Pace(const Scene& scene, const Plan& plan, const Simulation& simulation)
    : scene_(scene), simulation_(simulation), threads_(points, 0.0) {
    std::vector<Problem> none;
    const SceneShapes shapes = make_shapes(scene, none);
    const SceneNumbers n = scene_numbers(scene, shapes, plan.support);
    given_ = std::sqrt(std::max(0.0, n.speed * n.speed - 2 * n.gravity * n.fall));
    gravity_ = n.gravity, free_ = n.speed;
    for (const EmitterKeys& e : scene.emitters)
        add_thread(threads_, e, scene, n.nu, n.gravity, free_way(scene, shapes.solids, e.position, n.fall));
    if (scene.fluid.surface_tension > 0)
        tension_step_ = surface_tension_step(scene.fluid.density, plan.spacing, scene.fluid.surface_tension,
                                             plan.facts.viscous_implicitly() ? plan.largest_viscosity : 0);
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
    double speed = std::max(given_, threads_[at]);
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
        const bool unborn =
            limit.name == "surface tension" && simulation_.world().fluid.size() == 0;  // it asks the particles how viscous they are
        const double allowed = unborn ? tension_step_ : limit.dt(simulation_.world(), u);
        if (allowed > 0) dt = std::min(dt, allowed);
        // What will press is not known before the first solve: a column as high as the fluid is.
        if (limit.name == "pressure" && pressing_ > 0) dt = std::min(dt, scene_.time.cfl * scene_.fluid.spacing / pressing_);
    }
    return dt;
}

}  // namespace whorl

#include "tools/cost/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/surface_tension/surface_tension.h"
#include "engine/scene/numbers.h"
#include "engine/theory/falling_thread.h"
#include "render/look/look_options.h"

namespace whorl {
namespace {

/// Bytes that a run holds before its first particle: the program and its libraries; where it draws, the pipeline of pictures and GL; and
/// where it draws the fluid's surface, the distances around it and what they are built with.
constexpr double bytes_without_pictures = 46e6, bytes_with_pictures = 104e6, bytes_with_surface = 70e6, bytes_a_pixel = 64;
/// CPU seconds that the encoder takes, over what packing the same picture as PNG takes (measured at 640x360 and 1280x720).
constexpr double encode_over_png = 1.3;
/// What a thread is worth beside the others in a step (30 thousand particles, 2 threads: 0.8 to 0.95 by stage).
constexpr double parallel_efficiency = 0.85;

/// CPU seconds of what runs beside something else over those of the same alone: caches and the cores' units are shared (films of all
/// shipped scenes at draft).
constexpr double step_beside_pictures = 1.1, picture_beside_steps = 1.15;

/// Wall seconds over CPU seconds of a step.
double wall_over_cpu() { return 1 / (threads() > 1 ? parallel_efficiency * threads() : 1.0); }

double particles_at(const Scene& scene, const Plan& plan, double at_start, double time) {
    double volume = 0;
    for (const EmitterKeys& e : scene.emitters) {
        volume += emitted_volume(e, time, plan.dimensions());
        if (e.start <= time)
            volume += opening_area(e, plan.dimensions()) * (plan.support + 0.5 * plan.spacing);  // what waits in the nozzle
    }
    return at_start + volume / plan.particle_volume();
}

/// Between two pictures that were measured; before the first and after the last as those.
Calibration::Picture picture_at(const std::vector<Calibration::Picture>& pictures, double part) {
    const auto after =
        std::find_if(pictures.begin(), pictures.end(), [&](const Calibration::Picture& picture) { return picture.part >= part; });
    if (after == pictures.end()) return pictures.back();
    if (after == pictures.begin()) return pictures.front();
    const Calibration::Picture &a = after[-1], &b = *after;
    const double w = (part - a.part) / (b.part - a.part);
    return {part, (1 - w) * a.surface + w * b.surface, (1 - w) * a.draw + w * b.draw};
}

/// Between two of the moments that a coarse run was looked at.
double pace_at(const std::vector<double>& paces, double part) {
    const double at = std::clamp(part, 0.0, 1.0) * static_cast<double>(paces.size() - 1);
    const std::size_t k = std::min(static_cast<std::size_t>(at), paces.size() - 2);
    const double w = at - static_cast<double>(k);
    return (1 - w) * paces[k] + w * paces[k + 1];
}

}  // namespace

Estimate estimate(const SceneFile& file, const Plan& plan, const Simulation& simulation, const Calibration& c) {
    const Scene& scene = file.scene;
    Estimate e;
    e.frames = frame_count(scene);
    e.drawn = scene.output.frames && !c.pictures.empty();
    const Pace pace(scene, plan, simulation);
    const double interval = scene.time.frame_interval();

    const double at_start = static_cast<double>(simulation.world().fluid.size());
    const double most = particles_at(scene, plan, at_start, scene.time.end);
    // Without a coarse level, the iterations of the pressure equation grow with the number of particles across; those of the constraint,
    // which starts from the last step's pressures and from what pressed, hardly do (dam breaks of 2,000 to 49,000 particles over 1 to 4
    // s: 8.6 to 11.2 a step; more in the first tenths of a second).
    const bool grows = plan.pressure == PressureModel::ppe && plan.preconditioner != Preconditioner::multigrid;
    const double growth = plan.facts.pressure.form == PressureForm::constraint ? 1.0 / 12 : 1.0 / 3;
    const auto more_iterations = [&](double n) { return grows ? std::pow(std::max(1.0, n / c.particles), growth) : 1.0; };
    const bool film = !c.film_stages.empty();  // a coarse run knows the flow, and its iterations
    const StepCosts& costs = film ? c.film_stages : c.stages;
    e.iterations = film ? c.film_iterations : c.iterations * more_iterations(most);

    const double write = c.write * (1 + (scene.output.video ? encode_over_png : 0));
    const auto frame = [&](double time, double n, double steps) {
        Estimate at;
        for (const auto& [name, cost] : costs) {
            at.stages[name] = (cost.particle * n + cost.waits) * (e.drawn ? step_beside_pictures : 1) * wall_over_cpu() * steps *
                              (name == "pressure" && !film ? more_iterations(n) : 1);
            at.simulate += at.stages[name];
        }
        if (e.drawn) {
            const Calibration::Picture picture = picture_at(c.pictures, time / std::max(scene.time.end, 1e-300));
            at.surface = picture_beside_steps * picture.surface, at.draw = picture_beside_steps * picture.draw, at.write = write;
        }
        // The solver and the pictures share the cores: neither can be hidden behind the other beyond what the cores hold.
        at.frame =
            std::max(at.simulate, at.simulate + (at.surface + at.draw + at.write) / threads() - at.simulate * (1 - parallel_efficiency));
        return at;
    };
    double steps = 0, all_steps = 0;
    for (int k = 1; k <= e.frames; ++k) {
        const double time = frame_time(scene, k);
        double a_second = c.film_pace.size() < 2 ? 0 : pace_at(c.film_pace, time / frame_time(scene, e.frames));
        if (a_second == 0 || !plan.facts.pressure.solves_viscosity) a_second = std::max(a_second, 1 / pace.step(time));
        steps = k == 1 ? 0 : std::ceil(interval * a_second - 1e-9);  // the first frame is the start itself
        all_steps += steps;
        const Estimate at = frame(time, particles_at(scene, plan, at_start, time), steps);
        e.frames_seconds.push_back(at.frame);
        e.film += at.frame;
        e.film_simulate += at.simulate / wall_over_cpu(), e.film_surface += at.surface, e.film_draw += at.draw;
    }
    e.steps_a_frame = all_steps / std::max(1, e.frames - 1);
    e.step = all_steps > 0 ? interval / e.steps_a_frame : pace.step(0);
    const Estimate last = frame(scene.time.end, most, steps);
    e.stages = last.stages, e.simulate = last.simulate, e.surface = last.surface, e.draw = last.draw, e.write = last.write,
    e.frame = last.frame;
    const double pixels = static_cast<double>(scene.output.size[0]) * scene.output.size[1];
    e.memory = c.bytes_a_particle * most + bytes_without_pictures;
    if (scene.output.frames) e.memory += bytes_with_pictures + bytes_a_pixel * pixels + (shows_field(file.look) ? 0 : bytes_with_surface);
    return e;
}

Estimate estimate(const SceneFile& file) {
    const Plan plan = make_plan(file.scene);
    const Simulation simulation(file.scene, plan);
    return estimate(file, plan, simulation, calibrate(file, plan, simulation));
}

std::string memory_warning(const Estimate& estimate, double free_bytes) {
    if (estimate.memory <= free_bytes) return "";
    return fmt::format("the run needs about {:.3g} GB of memory at its end, and {:.3g} GB are free", estimate.memory / 1e9,
                       free_bytes / 1e9);
}

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

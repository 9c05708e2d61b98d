#include "tools/cost/estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/pressure/multigrid.h"
#include "engine/scene/numbers.h"
#include "tools/run/run.h"

namespace whorl {
namespace {

/// Bytes that a run holds before its first particle: the program, its libraries, and where it draws the pipeline of pictures and GL.
constexpr double bytes_without_pictures = 40e6, bytes_with_pictures = 150e6, bytes_a_pixel = 64;
/// CPU seconds that the encoder takes, over what packing the same picture as PNG takes (measured at 640x360 and 1280x720).
constexpr double encode_over_png = 1.3;
/// What a thread is worth beside the others in a step (30 thousand particles, 2 threads: 0.8 to 0.95 by stage).
constexpr double parallel_efficiency = 0.85;

/// Wall seconds over CPU seconds of a step.
double wall_over_cpu() { return 1 / (threads() > 1 ? parallel_efficiency * threads() : 1.0); }

/// How fast the fastest particle is most of the time [m/s]: viscosity holds it back; of water that splashes, one is about as fast as a free fall, for some
/// six times of that fall (a broken dam: steps measured), then about half as fast.
double usual_speed(const Scene& scene, const Plan& plan) {
    double given = 0;
    for (const EmitterKeys& e : scene.emitters)
        for (const double t : sample_times(e.start, std::min(e.stop, scene.time.end))) given = std::max(given, e.speed(t));
    const double g = scene.domain.gravity(0).norm(), nu = plan.largest_viscosity / scene.fluid.density;
    const double fall = plan.expected_speed * plan.expected_speed / std::max(2 * g, 1e-30);  // m, for which speed would be enough
    const double splashing = g > 0 ? std::min(1.0, 6 * std::sqrt(2 * fall / g) / scene.time.end) : 1;
    const double free = plan.expected_speed * (splashing + 0.5 * (1 - splashing));
    if (nu == 0) return std::max(given, free);
    return std::max(given, std::min(0.5 * plan.expected_speed, given + g * fall * fall / (3 * nu)));  // a thread under its own weight: g H^2/(3 nu)
}

double usual_step(const Scene& scene, const Plan& plan, const Simulation& simulation) {
    const double speed = usual_speed(scene, plan);
    double dt = speed > 0 ? scene.time.cfl * plan.spacing / speed : scene.time.max_step;
    const double fastest = largest_speed(simulation.world());
    for (const StepLimit& limit : simulation.assembly().limits)
        if (const double at_start = limit.dt(simulation.world(), fastest); at_start > 0) dt = std::min(dt, at_start);
    return std::min(dt, scene.time.frame_interval());
}

double particles_at(const Scene& scene, double at_start, double time) {
    double volume = 0;
    for (const EmitterKeys& e : scene.emitters) volume += emitted_volume(e, time);
    return at_start + volume / std::pow(scene.fluid.spacing, 3);
}

}  // namespace

Estimate estimate(const SceneFile& file, const Plan& plan, const Simulation& simulation, const Calibration& c) {
    const Scene& scene = file.scene;
    Estimate e;
    e.frames = frame_count(scene);
    e.drawn = scene.output.frames && c.draw;
    e.step = usual_step(scene, plan, simulation);
    e.steps_a_frame = std::ceil(scene.time.frame_interval() / e.step - 1e-9);

    const double at_start = static_cast<double>(simulation.world().fluid.size());
    const double most = particles_at(scene, at_start, scene.time.end);
    // Without a coarse level, the iterations of the pressure equation grow with the number of particles across.
    const Preconditioner M = scene.pressure.preconditioner;
    const bool grows = plan.pressure == PressureModel::ppe && M != Preconditioner::multigrid;
    const double grows_to = M != Preconditioner::automatic                           ? std::numeric_limits<double>::infinity()
                            : scene.pressure.form == PressureForm::constraint ? constraint_multigrid_above
                                                                                     : poisson_multigrid_above;
    const auto more_iterations = [&](double n) { return grows ? std::cbrt(std::max(1.0, std::min(n, grows_to) / c.particles)) : 1.0; };
    e.iterations = c.iterations * more_iterations(most);

    const double write = c.write * (1 + (scene.output.video ? encode_over_png : 0));
    const auto frame = [&](double n) {
        Estimate at;
        for (const auto& [name, seconds] : c.stages) {
            at.stages[name] = seconds * wall_over_cpu() * n * e.steps_a_frame * (name == "pressure" ? more_iterations(n) : 1);
            at.simulate += at.stages[name];
        }
        if (e.drawn) at.surface = c.surface * n, at.draw = *c.draw, at.write = write;
        // The solver and the pictures share the cores: neither can be hidden behind the other beyond what the cores hold.
        at.frame = std::max(at.simulate, at.simulate + (at.surface + at.draw + at.write) / threads() - at.simulate * (1 - parallel_efficiency));
        return at;
    };
    const Estimate last = frame(most);
    e.stages = last.stages, e.simulate = last.simulate, e.surface = last.surface, e.draw = last.draw, e.write = last.write, e.frame = last.frame;
    for (int k = 1; k <= e.frames; ++k) e.film += frame(particles_at(scene, at_start, frame_time(scene, k))).frame;
    const double pixels = static_cast<double>(scene.output.size[0]) * scene.output.size[1];
    e.memory = c.bytes_a_particle * most + (scene.output.frames ? bytes_with_pictures + bytes_a_pixel * pixels : bytes_without_pictures);
    return e;
}

}  // namespace whorl

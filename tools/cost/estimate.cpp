#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/scene/scene_scales.h"
#include "render/look/look_options.h"
#include "tools/cost/coarse_run.h"

namespace whorl {
namespace {

/// Bytes that a run needs independently of its particles: for the program and its libraries; in addition, if it draws images, for their
/// queues and GL; in addition, if it draws the fluid's surface, for the distance volume and its construction; per pixel of an image.
constexpr double bytes_without_pictures = 46e6, bytes_with_pictures = 104e6, bytes_with_surface = 70e6, bytes_a_pixel = 64;
/// Ratio of the CPU time of encoding an image into the video to that of compressing it as PNG (measured at 640x360 and 1280x720).
constexpr double encode_over_png = 1.3;
/// Parallel efficiency of a step (measured with 30,000 particles and 2 threads: 0.8 to 0.95, depending on the stage).
constexpr double parallel_efficiency = 0.85;

/// Ratio of the CPU time of steps and images when they run at the same time to their CPU time alone. It exceeds 1 because they share caches
/// and execution units (measured with all shipped scenes at draft quality).
constexpr double step_beside_pictures = 1.1, picture_beside_steps = 1.15;

/// Ratio of wall time to CPU time of a step.
double wall_over_cpu() { return 1 / (threads() > 1 ? parallel_efficiency * threads() : 1.0); }

/// Number of particles at a time [s]. @param at_start number at the start
double particles_at(const Scene& scene, const Plan& plan, double at_start, double time) {
    double volume = 0;
    for (const EmitterKeys& e : scene.emitters) {
        volume += emitted_volume(e, time, plan.dimensions());
        if (e.start <= time) volume += opening_area(e, plan.dimensions()) * (plan.support + 0.5 * plan.spacing);  // fluid in the nozzle
    }
    return at_start + volume / plan.particle_volume();
}

/// Cost of an image, interpolated between the measured ones and constant before the first and after the last. @param part elapsed fraction
/// of the run's time
CoarseRun::Picture picture_at(const std::vector<CoarseRun::Picture>& pictures, double part) {
    const auto after =
        std::find_if(pictures.begin(), pictures.end(), [&](const CoarseRun::Picture& picture) { return picture.part >= part; });
    if (after == pictures.end()) return pictures.back();
    if (after == pictures.begin()) return pictures.front();
    const CoarseRun::Picture &a = after[-1], &b = *after;
    const double w = (part - a.part) / (b.part - a.part);
    return {part, (1 - w) * a.surface + w * b.surface, (1 - w) * a.draw + w * b.draw};
}

/// Steps per simulated second, interpolated between the times of CoarseRun::pace. @param part elapsed fraction of the run's time
double pace_at(const std::vector<double>& paces, double part) {
    const double at = std::clamp(part, 0.0, 1.0) * static_cast<double>(paces.size() - 1);
    const std::size_t k = std::min(static_cast<std::size_t>(at), paces.size() - 2);
    const double w = at - static_cast<double>(k);
    return (1 - w) * paces[k] + w * paces[k + 1];
}

}  // namespace

Estimate estimate(const SceneFile& file, const Plan& plan, const Simulation& simulation, const CoarseRun& c) {
    const Scene& scene = file.scene;
    Estimate e;
    e.frames = frame_count(scene);
    e.drawn = scene.output.images && !c.pictures.empty();
    const double fastest = step_rate(simulation, simulation.world(), plan.expected_speed);
    const double interval = scene.time.frame_interval();

    const double at_start = static_cast<double>(simulation.world().fluid.size());
    const double most = particles_at(scene, plan, at_start, scene.time.end);
    e.iterations = c.iterations;

    const double write = c.write * (1 + (scene.output.video ? encode_over_png : 0));
    const auto frame = [&](double time, double n, double steps) {
        Estimate at;
        for (const auto& [name, cost] : c.stages) {
            at.stages[name] = (cost.particle * n + cost.waits) * (e.drawn ? step_beside_pictures : 1) * wall_over_cpu() * steps;
            at.simulate += at.stages[name];
        }
        if (e.drawn) {
            const CoarseRun::Picture picture = picture_at(c.pictures, time / std::max(scene.time.end, 1e-300));
            at.surface = picture_beside_steps * picture.surface, at.draw = picture_beside_steps * picture.draw, at.write = write;
        }
        // Solver and images share the cores. Images can use the time in which the solver's threads wait; the rest of their work adds to the
        // frame's time.
        at.frame =
            std::max(at.simulate, at.simulate + (at.surface + at.draw + at.write) / threads() - at.simulate * (1 - parallel_efficiency));
        return at;
    };
    double steps = 0, all_steps = 0;
    for (int k = 1; k <= e.frames; ++k) {
        const double time = frame_time(scene, k);
        const double steps_per_second = c.pace.empty() ? fastest : pace_at(c.pace, time / frame_time(scene, e.frames));
        steps = k == 1 ? 0 : std::ceil(interval * steps_per_second - 1e-9);  // the first frame is the initial state
        all_steps += steps;
        const Estimate at = frame(time, particles_at(scene, plan, at_start, time), steps);
        e.frames_seconds.push_back(at.frame);
        e.film += at.frame;
        e.film_simulate += at.simulate / wall_over_cpu(), e.film_surface += at.surface, e.film_draw += at.draw;
    }
    e.steps_a_frame = all_steps / std::max(1, e.frames - 1);
    e.step = all_steps > 0 ? interval / e.steps_a_frame : 1 / fastest;
    const Estimate last = frame(scene.time.end, most, steps);
    e.stages = last.stages, e.simulate = last.simulate, e.surface = last.surface, e.draw = last.draw, e.write = last.write,
    e.frame = last.frame;
    const double pixels = static_cast<double>(scene.output.size[0]) * scene.output.size[1];
    e.memory = c.bytes_a_particle * most + bytes_without_pictures;
    if (scene.output.images) e.memory += bytes_with_pictures + bytes_a_pixel * pixels + (shows_field(file.look) ? 0 : bytes_with_surface);
    return e;
}

Estimate estimate(const SceneFile& file) {
    const Plan plan = make_plan(file.scene);
    const Simulation simulation(file.scene, plan);
    return estimate(file, plan, simulation, coarse_run(file, simulation));
}

std::string memory_warning(const Estimate& estimate, double free_bytes) {
    if (estimate.memory <= free_bytes) return "";
    return fmt::format("the run needs about {:.3g} GB of memory at its end, but only {:.3g} GB are free", estimate.memory / 1e9,
                       free_bytes / 1e9);
}

void StepMeter::begin(const Simulation& simulation) {
    with_all_ = !with_all_ && threads() > 1;
    if (!with_all_) alone_.emplace();
    times_ = simulation.times(), totals_ = simulation.totals();
}

void StepMeter::end(const Simulation& simulation) {
    alone_.reset();
    Sum& sum = with_all_ ? all_ : one_;
    for (const auto& [name, t] : simulation.times()) {
        const auto before = times_.find(name);
        sum.cpu[name] += t.cpu - (before == times_.end() ? 0 : before->second.cpu);
    }
    sum.particle_steps += simulation.totals().particle_steps - totals_.particle_steps;
    sum.steps += simulation.totals().steps - totals_.steps;
}

StepCosts StepMeter::costs() const {
    StepCosts costs;
    const Sum& own = one_.particle_steps > 0 ? one_ : all_;
    for (const auto& [name, cpu] : own.cpu) costs[name].particle = cpu / std::max(1.0, own.particle_steps);
    if (one_.particle_steps > 0 && all_.particle_steps > 0)
        for (const auto& [name, cpu] : all_.cpu)
            costs[name].waits =
                std::max(0.0, cpu - costs[name].particle * all_.particle_steps) / static_cast<double>(std::max(1L, all_.steps));
    return costs;
}

}  // namespace whorl

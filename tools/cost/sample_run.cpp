#include "tools/cost/sample_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "engine/io/snapshot.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/scene/numbers.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

VectorExpression constant(const Vec3d& v) { return {{Expression(v.x()), Expression(v.y()), Expression(v.z())}}; }

/// A viscosity that depends on age [s], as one that depends on height: what lies lowest left the nozzle a whole film ago.
Expression viscosity_by_height(const Expression& of_age, double end, double length) {
    return Expression(std::regex_replace(of_age.text(), std::regex("\\bage\\b"), fmt::format("({:.9g}*max(0, 1-y/{:.9g}))", end, length)));
}

void pour(Scene& scene, const EmitterKeys& emitter, const Expression& viscosity, double particles) {
    const double d = scene.fluid.spacing, radius = half_thickness(emitter, d) * d;
    const double length = std::min(particles * d * d * d / (M_PI * radius * radius), 40 * radius);
    BlockKeys rope;
    rope.shape.kind = "cylinder";
    rope.shape.from = {0, 0.5 * d, 0}, rope.shape.to = {0, 0.5 * d + length, 0}, rope.shape.radius = radius;
    rope.velocity = constant({0.1 * emitter.speed(emitter.start), -emitter.speed(emitter.start), 0});  // aslant, so that it bends
    rope.sampling = Sampling::blue_noise;
    if (depends_on_age(viscosity)) scene.fluid.viscosity = viscosity_by_height(viscosity, scene.time.end, length);
    scene.blocks = {rope};
    // The nozzle goes on pushing from above, so that the rope bends and every solve has something new to find.
    EmitterKeys nozzle;
    nozzle.position = {0, rope.shape.to.y(), 0}, nozzle.direction = {0, -1, 0}, nozzle.radius = radius,
    nozzle.speed = Expression(emitter.speed(emitter.start));
    scene.emitters = {nozzle};
    scene.domain.min = {-10 * radius, -6 * d, -10 * radius}, scene.domain.max = {10 * radius, length + 10 * d, 10 * radius};
    SolidKeys floor;
    floor.shape.min = {-8 * radius, -4 * d, -8 * radius}, floor.shape.max = {8 * radius, 0, 8 * radius};
    scene.solids = {floor};
}

/// The plane needs more layers than space for as many particles.
double stretched(const Scene& scene) { return scene.domain.dimensions == 2 ? 4 : 1; }

/// Of a scene laid out in space, what the plane has of it.
void lay_flat(Scene& scene) {
    for (BlockKeys& block : scene.blocks) block.shape.cut = true;
    for (SolidKeys& solid : scene.solids) solid.shape.cut = true;
    scene.domain.min.z() = scene.domain.max.z() = 0;
    scene.domain.periodic[2] = false;
}

void half_fill_a_tank(Scene& scene) {
    const double d = stretched(scene) * scene.fluid.spacing;
    BlockKeys water;
    water.shape.min = {0, 0, 0}, water.shape.max = {14 * d, 16 * d, 14 * d};
    water.velocity = constant(Vec3d::Zero());
    scene.blocks = {water};
    SolidKeys tank;
    tank.shape.min = {0, 0, 0}, tank.shape.max = {20 * d, 30 * d, 14 * d};
    tank.inside = true;
    scene.solids = {tank};
    scene.domain.min = Vec3d::Constant(-6 * d), scene.domain.max = Vec3d(26, 36, 20) * d;
}

void turn_a_drop(Scene& scene, double speed) {
    const double d = stretched(scene) * scene.fluid.spacing, radius = 9 * d, rate = 0.5 * speed / radius;
    BlockKeys drop;
    drop.shape.kind = "sphere";
    drop.shape.centre = Vec3d::Zero(), drop.shape.radius = radius;
    drop.velocity = {{Expression(fmt::format("{:.9g}*y", -rate)), Expression(fmt::format("{:.9g}*x", rate)), Expression(0.0)}};
    scene.blocks = {drop};
    scene.domain.min = Vec3d::Constant(-3 * radius), scene.domain.max = Vec3d::Constant(3 * radius);
}

void shear(Scene& scene, double speed) {
    const double d = stretched(scene) * scene.fluid.spacing, edge = 14 * d;
    BlockKeys box;
    box.shape.min = Vec3d::Zero(), box.shape.max = Vec3d::Constant(edge);
    box.velocity = {{Expression(fmt::format("{:.9g}*sin({:.9g}*y)", speed, 2 * M_PI / edge)), Expression(0.0), Expression(0.0)}};
    scene.blocks = {box};
    scene.domain.min = Vec3d::Zero(), scene.domain.max = Vec3d::Constant(edge);
}

/// Ink that differs from place to place.
void tint(Scene& scene) {
    const Expression wave(fmt::format("0.5+0.5*sin({:.9g}*x)", 2 * M_PI / (10 * scene.fluid.spacing)));
    for (BlockKeys& block : scene.blocks) block.ink.of = {wave};
}

}  // namespace

double poured_particles(const Plan& plan) { return std::clamp(plan.estimated_particles, 600.0, 1500.0); }

double half_thickness(const EmitterKeys& e, double d) {
    return std::clamp((e.shape == "disc" ? e.radius : 0.5 * std::min(e.width, e.thickness)) / d, 1.5, 6.0);
}

SceneFile sample_of(const SceneFile& file, const Plan& plan) {
    SceneFile sample = file;
    Scene& scene = sample.scene;
    const bool emits_only = !scene.emitters.empty() && scene.blocks.empty();
    const bool closed = scene.domain.box().all_periodic();
    const bool solids = !scene.solids.empty();
    const double pull = scene.domain.gravity(0).norm();
    const std::vector<EmitterKeys> emitters = scene.emitters;
    const Expression poured = emits_only ? scene.viscosity_of_source(1) : scene.fluid.viscosity;

    // The models are the plan's, not chosen again for the small scene.
    scene.models.pressure = plan.pressure;
    scene.models.viscosity = plan.viscosity;
    scene.models.shifting = plan.shifting;
    if (plan.preconditioner == Preconditioner::multigrid) scene.pressure.preconditioner = plan.preconditioner;
    if (plan.sound_speed > 0) scene.pressure.sound_speed = plan.sound_speed;
    scene.fluid.kernel = plan.kernel.kind;
    scene.fluid.support = plan.support / scene.fluid.spacing;
    scene.fluid.viscosity = Expression(plan.largest_viscosity);
    scene.emitters.clear(), scene.probes.clear(), scene.solids.clear(), scene.drains.clear(), scene.streams.clear(), scene.vortices.clear(),
        scene.places.clear();
    scene.domain.gravity = constant({0, -pull, 0});
    sample.camera = {};

    scene.domain.periodic = {closed, closed, closed};
    if (emits_only) pour(scene, emitters.front(), poured, poured_particles(plan));
    else if (closed) shear(scene, plan.expected_speed);
    else if (solids) half_fill_a_tank(scene);
    else turn_a_drop(scene, plan.expected_speed);
    // The tank and the drop have surfaces that the projection of velocities refuses, and no other form has surface tension in the plane.
    if (!closed && scene.pressure.source == PressureSource::velocity) {
        scene.pressure.form.reset();
        if (scene.domain.dimensions == 2) scene.fluid.surface_tension = 0;
    }
    if (!solids && !closed) scene.solids.clear(), scene.domain.gravity = constant(Vec3d::Zero());
    if (file.scene.any_ink()) tint(scene);
    if (scene.domain.dimensions == 2) lay_flat(scene);
    scene.time.end = 1e3 * scene.time.max_step;
    return sample;
}

namespace {

template <class T>
void repeat_each(std::vector<T>& values, std::size_t times) {
    std::vector<T> all;
    all.reserve(times * values.size());
    for (const T& value : values) all.insert(all.end(), times, value);
    values = std::move(all);
}

}  // namespace

bool run_coarsely(const SceneFile& file, double coarser, int moments, const std::vector<std::string>& fields,
                  const std::function<void(const Frame&, const Simulation&)>& show, const std::function<void(double)>& progress) try {
    const std::string spacing = fmt::format("fluid.spacing={:.9g}", coarser * file.scene.fluid.spacing);
    const SceneFile coarse = changed(file, {read_change(parse_change(spacing))});
    Replay replay(coarse);
    Simulation simulation(coarse.scene, make_plan(coarse.scene));
    const Snapshots snapshots(simulation, fields);
    const double first = frame_time(file.scene, 1), last = frame_time(file.scene, frame_count(file.scene));
    show(snapshots.take(simulation, 1), simulation);
    for (int k = 1; k <= moments; ++k) {
        const double time = first + k * (last - first) / moments;
        while (simulation.time() < time) {
            if (simulation.step(time).diverged) return false;
            replay.apply_until(simulation.time(), [&](const Scene& s, const Plan& p, double when) { simulation.change(s, p, when); });
            progress((simulation.time() - first) / (last - first));
        }
        show(snapshots.take(simulation, 1), simulation);
    }
    return true;
} catch (const InputError&) { return false; }

Frame parted(const Frame& coarse, int coarser) {
    Frame frame = coarse;
    frame.spacing /= static_cast<float>(coarser);
    std::vector<Vec3f> offsets;
    const float first = -0.5f * static_cast<float>(coarser - 1);
    const int layers = frame.dimensions == 3 ? coarser : 1;
    for (int i = 0; i < coarser; ++i)
        for (int j = 0; j < coarser; ++j)
            for (int k = 0; k < layers; ++k)
                offsets.push_back(frame.spacing * Vec3f(first + static_cast<float>(i), first + static_cast<float>(j),
                                                        layers > 1 ? first + static_cast<float>(k) : 0));
    repeat_each(frame.position, offsets.size());
    for (std::size_t i = 0; i < frame.position.size(); ++i) {
        Vec3f& x = frame.position[i];
        x += offsets[i % offsets.size()];
        for (int a = 0; a < frame.dimensions; ++a) {
            const float length = frame.domain_max[a] - frame.domain_min[a];
            if (frame.periodic[a]) x[a] += x[a] < frame.domain_min[a] ? length : x[a] >= frame.domain_max[a] ? -length : 0;
        }
    }
    repeat_each(frame.velocity, offsets.size());
    for (auto& [name, values] : frame.scalar) repeat_each(values, offsets.size());
    for (auto& [name, values] : frame.vector) repeat_each(values, offsets.size());
    for (auto& [name, values] : frame.whole) repeat_each(values, offsets.size());
    return frame;
}

}  // namespace whorl

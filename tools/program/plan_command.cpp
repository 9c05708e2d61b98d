#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/core/parallel.h"
#include "engine/sim/simulation.h"
#include "tools/cost/estimate.h"
#include "tools/film/panels.h"
#include "tools/film/progress.h"
#include "tools/program/command.h"
#include "tools/program/run_options.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

/// The scene as it would begin, and what its first step would obey.
struct Preview {
    const Plan& plan;
    const Assembly& assembly;
    const World& world;
    const Calibration& calibration;
    const Estimate& cost;
    double film;  ///< s, wall: of all panels, one after the other
};

std::size_t bytes_a_particle(const World& world) {
    std::size_t bytes = 0;
    for (const ParticleStore::Entry* e : world.fluid.entries()) bytes += e->info->bytes;
    return bytes;
}

const char* name_of(Access access) { return access == Access::read ? "reads" : access == Access::write ? "writes" : "updates"; }

/// What a limit says of the scene at its start [s]; infinite where it does not bind.
double at_start(const StepLimit& limit, const World& world) {
    const double dt = limit.dt(world, largest_speed(world));
    return dt > 0 ? dt : std::numeric_limits<double>::infinity();
}

const StepLimit* binding(const Preview& p) {
    const StepLimit* least = nullptr;
    for (const StepLimit& limit : p.assembly.limits)
        if (!least || at_start(limit, p.world) < at_start(*least, p.world)) least = &limit;
    return least;
}

void print_cost(const Preview& p) {
    const Estimate& e = p.cost;
    fmt::print("\ncost on this machine with {} threads, from {:.0f} particles of the same models {}\n", threads(), p.calibration.particles,
               p.calibration.kept ? "measured earlier" : "measured now");
    fmt::print("  iterations             about {:.0f} a step\n", e.iterations);
    fmt::print("  steps                  about {:.0f} a frame, of {:.3g} s\n", e.steps_a_frame, e.step);
    fmt::print("  the last frame         {:.0f} ms: simulate {:.0f}", 1e3 * e.frame, 1e3 * e.simulate);
    std::string parts;
    for (const auto& [name, seconds] : e.stages)
        if (seconds > 0.02 * e.simulate) parts += fmt::format("{}{} {:.0f}", parts.empty() ? "" : ", ", name, 1e3 * seconds);
    fmt::print(" ({})", parts);
    if (e.drawn) fmt::print("; CPU ms of surface {:.0f}, draw {:.0f}, write {:.0f}", 1e3 * e.surface, 1e3 * e.draw, 1e3 * e.write);
    fmt::print("\n  the whole film         {} for {} frames{}{}\n", duration(p.film), e.frames, p.film > e.film ? " of every panel" : "",
               e.drawn ? "" : ", without pictures");
    fmt::print("  memory                 {:.0f} MB, {:.0f} bytes a particle with neighbours and matrices\n", 1e-6 * e.memory,
               p.calibration.bytes_a_particle);
}

Json cost_json(const Preview& p) {
    const Estimate& e = p.cost;
    return {{"threads", threads()},
            {"calibration_particles", p.calibration.particles},
            {"step", e.step},
            {"steps_per_frame", e.steps_a_frame},
            {"iterations_per_step", e.iterations},
            {"last_frame_seconds", e.frame},
            {"last_frame_simulate_seconds", e.simulate},
            {"last_frame_simulate_stages", e.stages},
            {"last_frame_cpu_seconds", e.drawn ? Json{{"surface", e.surface}, {"draw", e.draw}, {"write", e.write}} : Json()},
            {"film_seconds", p.film},
            {"frames", e.frames},
            {"memory_bytes", e.memory},
            {"bytes_a_particle", p.calibration.bytes_a_particle}};
}

void print_text(const SceneFile& file, const Preview& p) {
    fmt::print("{}: {:g} s, a frame every {:.4g} s\n\nmodels\n", file.scene.name, file.scene.time.end, file.scene.time.frame_interval());
    for (const Choice& c : p.plan.choices) fmt::print("  {:<29} {:<12} {}{}\n", c.key, c.value, c.automatic ? "auto: " : "", c.reason);

    fmt::print("\nfields, {} bytes a particle\n", bytes_a_particle(p.world));
    for (const ParticleStore::Entry* e : p.world.fluid.entries())
        fmt::print("  {:<22} {:>3} B  {:<8} {}{}\n", e->info->name, e->info->bytes, e->lasting ? "lasting" : "scratch", e->info->meaning,
                   e->info->unit.empty() ? "" : fmt::format(" [{}]", e->info->unit));

    fmt::print("\nstages of a step, in order\n");
    for (const Stage& stage : p.assembly.stages) {
        fmt::print("  {:<22}", stage.name);
        for (const Access access : {Access::read, Access::update, Access::write}) {
            std::string names;
            for (const FieldAccess& a : stage.accesses)
                if (a.access == access) names += (names.empty() ? " " : ", ") + std::string(a.field->name);
            if (!names.empty()) fmt::print(" {}{};", name_of(access), names);
        }
        fmt::print("\n");
    }

    fmt::print("\nlimits of the time step, at the start\n");
    const StepLimit* least = binding(p);
    for (const StepLimit& limit : p.assembly.limits) {
        const double dt = at_start(limit, p.world);
        fmt::print("  {:<22} {:<12} {}{}\n", limit.name, std::isfinite(dt) ? fmt::format("{:.3g} s", dt) : "-", limit.formula,
                   &limit == least ? "   <- binds" : "");
    }
    fmt::print("\nparticles                {} at the start, about {:.0f} at the end; fastest expected {:.3g} m/s\n", p.world.fluid.size(),
               p.plan.estimated_particles, p.plan.expected_speed);
    print_cost(p);
    for (const std::string& warning : p.plan.warnings) fmt::print("warning: {}\n", warning);
}

void print_json(const SceneFile& file, const Preview& p) {
    Json choices = Json::array(), fields = Json::array(), stages = Json::array(), limits = Json::array();
    for (const Choice& c : p.plan.choices)
        choices.push_back({{"key", c.key}, {"value", c.value}, {"automatic", c.automatic}, {"reason", c.reason}});
    for (const ParticleStore::Entry* e : p.world.fluid.entries())
        fields.push_back({{"name", e->info->name},
                          {"bytes", e->info->bytes},
                          {"lasting", e->lasting},
                          {"unit", e->info->unit},
                          {"meaning", e->info->meaning}});
    for (const Stage& stage : p.assembly.stages) {
        Json accesses = Json::object();
        for (const FieldAccess& a : stage.accesses) accesses[name_of(a.access)].push_back(a.field->name);
        stages.push_back({{"name", stage.name}, {"group", stage.group}, {"fields", accesses}});
    }
    const StepLimit* least = binding(p);
    for (const StepLimit& limit : p.assembly.limits) {
        const double dt = at_start(limit, p.world);
        limits.push_back({{"name", limit.name},
                          {"formula", limit.formula},
                          {"step", std::isfinite(dt) ? Json(dt) : Json()},
                          {"binds", &limit == least}});
    }
    const Json all = {{"scene", file.scene.name},
                      {"end", file.scene.time.end},
                      {"frame_interval", file.scene.time.frame_interval()},
                      {"models", choices},
                      {"fields", fields},
                      {"bytes_a_particle", bytes_a_particle(p.world)},
                      {"stages", stages},
                      {"limits", limits},
                      {"particles_at_start", p.world.fluid.size()},
                      {"expected_particles", p.plan.estimated_particles},
                      {"expected_speed", p.plan.expected_speed},
                      {"cost", cost_json(p)},
                      {"warnings", p.plan.warnings}};
    fmt::print("{}\n", all.dump(2));
}

/// Wall seconds of the whole film: a scene with panels is run once for each.
double film_seconds(const SceneFile& file, const Estimate& alone) {
    if (file.scene.panels.empty()) return alone.film;
    double sum = 0;
    for (const SceneFile& panel : panel_scenes(file)) {
        const Plan plan = make_plan(panel.scene);
        sum += estimate(panel, plan, Simulation(panel.scene, plan), calibrate(panel, plan)).film;
    }
    return sum;
}

int preview(const Options& options) {
    set_threads(options.threads);
    const SceneFile file = read_scene_file(options);
    const Plan plan = make_plan(file.scene);
    const Simulation simulation(file.scene, plan);
    const Calibration calibration = calibrate(file, plan);
    const Estimate cost = estimate(file, plan, simulation, calibration);
    const Preview p{plan, simulation.assembly(), simulation.world(), calibration, cost, film_seconds(file, cost)};
    options.json ? print_json(file, p) : print_text(file, p);
    return exit_done;
}

}  // namespace

void add_plan(CLI::App& program, Job& chosen) {
    const auto options = std::make_shared<Options>();
    CLI::App* app = program.add_subcommand("plan", "what would be modelled, why, and what it costs; the scene is not run");
    using O = Option;
    add_options(
        *app, *options,
        {O::scene, O::set, O::with, O::until, O::size, O::fps, O::quality, O::no_video, O::no_images, O::threads, O::seed, O::json});
    app->footer(
        "Examples:\n"
        "  whorl plan honey_coil\n"
        "  whorl plan honey_coil --set fluid.viscosity=0.001        what changes when honey becomes water\n");
    app->callback([options, &chosen] { chosen = [options] { return preview(*options); }; });
}

}  // namespace whorl

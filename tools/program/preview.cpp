#include "tools/program/preview.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/parallel.h"
#include "tools/film/progress.h"
#include "tools/film/report.h"
#include "tools/process/json_text.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

std::size_t bytes_a_particle(const ParticleStore& fluid) {
    std::size_t bytes = 0;
    for (const ParticleStore::Entry* e : fluid.entries()) bytes += e->info->bytes;
    return bytes;
}

const char* name_of(Access access) { return access == Access::read ? "reads" : access == Access::write ? "writes" : "updates"; }

/// Time step that a limit allows at the start [s]; infinite if it does not apply.
double at_start(const StepLimit& limit, const World& world) {
    const double dt = limit.dt(world, largest_speed(world));
    return dt > 0 ? dt : std::numeric_limits<double>::infinity();
}

/// Limit with the smallest time step at the start; null without limits.
const StepLimit* binding(const Simulation& simulation) {
    const World& world = simulation.world();
    const StepLimit* least = nullptr;
    for (const StepLimit& limit : simulation.assembly().limits)
        if (!least || at_start(limit, world) < at_start(*least, world)) least = &limit;
    return least;
}

/// Number of particles at the end of the run. Without emitters it is the number at the start.
double expected_particles(const Preview& p) {
    const double at_start = p.simulation.world().fluid.size();
    return p.file.scene.emitters.empty() ? at_start : std::max(at_start, p.plan.estimated_particles);
}

void print_cost(const Preview& p) {
    const CoarseRun& run = *p.coarse;
    const Estimate& e = p.cost;
    fmt::print("\ncost on this machine with {} threads, predicted from a run {} that took {:.2g} s ({})\n", threads(),
               run.coarser > 1 ? fmt::format("with {} times the spacing", run.coarser) : "of the scene's beginning", run.seconds,
               run.kept ? "made earlier" : "made now");
    fmt::print("  iterations             about {:.0f} per step\n", e.iterations);
    fmt::print("  steps                  about {:.0f} of {:.3g} s per frame\n", e.steps_a_frame, e.step);
    fmt::print("  last frame             {:.0f} ms: simulate {:.0f}", 1e3 * e.frame, 1e3 * e.simulate);
    std::string parts;
    for (const auto& [name, seconds] : e.stages)
        if (seconds > 0.02 * e.simulate) parts += fmt::format("{}{} {:.0f}", parts.empty() ? "" : ", ", name, 1e3 * seconds);
    fmt::print(" ({})", parts);
    if (e.drawn) fmt::print("; CPU ms: surface {:.0f}, draw {:.0f}, write {:.0f}", 1e3 * e.surface, 1e3 * e.draw, 1e3 * e.write);
    fmt::print("\n  whole run              {} for {} frames{}{}\n", duration(e.film), e.frames,
               p.file.scene.panels.empty() ? "" : " of every panel", e.drawn ? "" : ", without images");
    fmt::print("  memory                 {:.0f} MB, {:.0f} bytes per particle with neighbours and matrices\n", 1e-6 * e.memory,
               run.bytes_a_particle);
}

Json cost_json(const CoarseRun& run, const Estimate& e) {
    return {{"threads", threads()},
            {"coarse_run", {{"spacing", run.coarser}, {"particles", run.particles}, {"cpu_seconds", run.seconds}}},
            {"step", e.step},
            {"steps_per_frame", e.steps_a_frame},
            {"iterations_per_step", e.iterations},
            {"last_frame_seconds", e.frame},
            {"last_frame_simulate_seconds", e.simulate},
            {"last_frame_simulate_stages", e.stages},
            {"last_frame_cpu_seconds", e.drawn ? Json{{"surface", e.surface}, {"draw", e.draw}, {"write", e.write}} : Json()},
            {"film_seconds", e.film},
            {"film_cpu_seconds", Json{{"simulate", e.film_simulate}, {"surface", e.film_surface}, {"draw", e.film_draw}}},
            {"frames", e.frames},
            {"memory_bytes", e.memory},
            {"bytes_a_particle", run.bytes_a_particle}};
}

void print_models(const Preview& p) {
    const Scene& scene = p.file.scene;
    fmt::print("{}: {:g} s, a frame every {:.4g} s\n\nmodels\n", scene.name, scene.time.end, scene.time.frame_interval());
    for (const Choice& c : p.plan.choices) fmt::print("  {:<29} {:<12} {}{}\n", c.key, c.value, c.automatic ? "auto: " : "", c.reason);
}

void print_fields(const ParticleStore& fluid) {
    fmt::print("\nfields, {} bytes per particle\n", bytes_a_particle(fluid));
    for (const ParticleStore::Entry* e : fluid.entries())
        fmt::print("  {:<22} {:>3} B  {:<8} {}{}\n", e->info->name, e->info->bytes, e->lasting ? "lasting" : "scratch", e->info->meaning,
                   e->info->unit.empty() ? "" : fmt::format(" [{}]", e->info->unit));
}

void print_stages(const std::vector<Stage>& stages) {
    fmt::print("\nstages of a step, in order\n");
    for (const Stage& stage : stages) {
        fmt::print("  {:<22}", stage.name);
        for (const Access access : {Access::read, Access::update, Access::write}) {
            std::string names;
            for (const FieldAccess& a : stage.accesses)
                if (a.access == access) names += (names.empty() ? " " : ", ") + std::string(a.field->name);
            if (!names.empty()) fmt::print(" {}{};", name_of(access), names);
        }
        fmt::print("\n");
    }
}

void print_limits(const Simulation& simulation) {
    fmt::print("\nlimits of the time step, at the start\n");
    const StepLimit* least = binding(simulation);
    for (const StepLimit& limit : simulation.assembly().limits) {
        const double dt = at_start(limit, simulation.world());
        fmt::print("  {:<22} {:<12} {}{}\n", limit.name, std::isfinite(dt) ? fmt::format("{:.3g} s", dt) : "-", limit.formula,
                   &limit == least ? "   <- binds" : "");
    }
}

void print_text(const Preview& p) {
    print_models(p);
    if (p.coarse) {
        print_fields(p.simulation.world().fluid);
        print_stages(p.simulation.assembly().stages);
        print_limits(p.simulation);
    }
    fmt::print("\nparticles                {} at the start, about {:.0f} at the end; expected speed up to {:.3g} m/s\n",
               p.simulation.world().fluid.size(), expected_particles(p), p.plan.expected_speed);
    if (p.coarse) print_cost(p);
    for (const std::string& warning : p.plan.warnings) fmt::print("warning: {}\n", warning);
    if (!p.coarse) fmt::print("{} into {}\n", counted(p.frames, "frame"), p.folder.string());
}

void print_json(const Preview& p) {
    const Scene& scene = p.file.scene;
    const World& world = p.simulation.world();
    Json fields = Json::array(), stages = Json::array(), limits = Json::array();
    for (const ParticleStore::Entry* e : world.fluid.entries())
        fields.push_back({{"name", e->info->name},
                          {"bytes", e->info->bytes},
                          {"lasting", e->lasting},
                          {"unit", e->info->unit},
                          {"meaning", e->info->meaning}});
    for (const Stage& stage : p.simulation.assembly().stages) {
        Json accesses = Json::object();
        for (const FieldAccess& a : stage.accesses) accesses[name_of(a.access)].push_back(a.field->name);
        stages.push_back({{"name", stage.name}, {"group", stage.group}, {"fields", accesses}});
    }
    const StepLimit* least = binding(p.simulation);
    for (const StepLimit& limit : p.simulation.assembly().limits) {
        const double dt = at_start(limit, world);
        limits.push_back({{"name", limit.name},
                          {"formula", limit.formula},
                          {"step", std::isfinite(dt) ? Json(dt) : Json()},
                          {"binds", &limit == least}});
    }
    Json all = {
        {"scene", scene.name},
        {"end", scene.time.end},
        {"frame_interval", scene.time.frame_interval()},
        {"models", choices_json(p.plan)},
        {"fields", fields},
        {"bytes_a_particle", bytes_a_particle(world.fluid)},
        {"stages", stages},
        {"limits", limits},
        {"particles_at_start", world.fluid.size()},
        {"expected_particles", expected_particles(p)},
        {"expected_speed", p.plan.expected_speed},
    };
    if (p.coarse) all["cost"] = cost_json(*p.coarse, p.cost);
    all["warnings"] = p.plan.warnings;
    if (!p.coarse) all["frames"] = p.frames, all["folder"] = p.folder.string();
    fmt::print("{}\n", json_text(all, 2));
}

}  // namespace

void print_preview(const Preview& preview, bool json) { json ? print_json(preview) : print_text(preview); }

}  // namespace whorl

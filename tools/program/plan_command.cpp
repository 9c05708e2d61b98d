
#include "engine/core/parallel.h"
#include "engine/probes/comparison.h"
#include "engine/scene/available_memory.h"
#include "engine/simulation/simulation.h"
#include "tools/cost/coarse_run.h"
#include "tools/film/panel_scenes.h"
#include "tools/film/progress.h"
#include "tools/program/command.h"
#include "tools/program/preview.h"

namespace whorl {
namespace {

/// Adds the estimate of the scene. For panels, which run one after the other, it sums their times and uses their largest memory.
void add_cost(Preview& preview, const Watch& watch) {
    const SceneFile& file = preview.file;
    for (const SceneFile& run : file.scene.panels.empty() ? std::vector{file} : panel_scenes(file)) {
        const Plan plan = make_plan(run.scene);
        const Simulation simulation(run.scene, plan);
        preview.coarse = coarse_run(run, simulation, watch);
        Estimate e = estimate(run, plan, simulation, *preview.coarse);
        const Estimate& before = preview.cost;
        e.film += before.film, e.film_simulate += before.film_simulate, e.film_surface += before.film_surface;
        e.film_draw += before.film_draw, e.memory = std::max(e.memory, before.memory);
        preview.cost = std::move(e);
    }
}

int plan(const Options& options) {
    set_threads(options.threads);
    const SceneFile file = read_scene_file(options);
    Plan plan = make_plan(file);
    const Simulation simulation(file.scene, plan);
    check_probes(simulation);
    Preview preview{file, plan, simulation};
    add_cost(preview, watch_coarse_run(options.json));
    if (!file.scene.panels.empty()) plan.warnings = warnings_of(file);  // warnings of the panels' runs
    if (const std::string warning = memory_warning(preview.cost, available_memory()); !warning.empty()) plan.warnings.push_back(warning);
    print_preview(preview, options.json);
    return exit_done;
}

}  // namespace

void add_plan(CLI::App& program, Job& chosen) {
    const auto [app, o] = add_command(program, chosen, "plan",
                                      "print models with reasons, fields, stages and predicted cost, without running the scene", plan,
                                      "Examples:\n"
                                      "  whorl plan honey_coil\n"
                                      "  whorl plan honey_coil --set fluid.viscosity=0.001        the models for water instead of honey\n");
    add_options(
        app, o,
        {&o.scene, &o.set, &o.with, &o.until, &o.size, &o.fps, &o.quality, &o.no_video, &o.no_images, &o.threads, &o.seed, &o.json});
}

}  // namespace whorl

#include <CLI/CLI.hpp>
#include <memory>

#include "engine/core/parallel.h"
#include "engine/scene/free_memory.h"
#include "engine/sim/simulation.h"
#include "tools/cost/estimate.h"
#include "tools/film/panel_scenes.h"
#include "tools/program/command.h"
#include "tools/program/preview.h"
#include "tools/scene_file/camera_warnings.h"

namespace whorl {
namespace {

/// A scene with panels is run once for each.
FilmCost film_cost(const SceneFile& file, const Estimate& alone) {
    if (file.scene.panels.empty()) return {alone.film, alone.film_simulate, alone.film_surface, alone.film_draw};
    FilmCost sum;
    for (const SceneFile& panel : panel_scenes(file)) {
        const Estimate e = estimate(panel);
        sum.wall += e.film, sum.simulate += e.film_simulate, sum.surface += e.film_surface, sum.draw += e.film_draw;
    }
    return sum;
}

int plan(const Options& options) {
    set_threads(options.threads);
    const SceneFile file = read_scene_file(options);
    Plan plan = make_plan(file);
    const Simulation simulation(file.scene, plan);
    const Calibration calibration = calibrate(file, plan, simulation);
    const Estimate cost = estimate(file, plan, simulation, calibration);
    if (const std::string warning = memory_warning(cost, free_memory()); !warning.empty()) plan.warnings.push_back(warning);
    const Preview preview{file, plan, simulation, PreviewCost{calibration, cost, film_cost(file, cost)}};
    options.json ? print_json(preview) : print_text(preview);
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
    app->callback([options, &chosen] { chosen = [options] { return plan(*options); }; });
}

}  // namespace whorl

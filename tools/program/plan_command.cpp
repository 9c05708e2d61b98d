#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "engine/core/parallel.h"
#include "engine/probes/comparison.h"
#include "engine/scene/free_memory.h"
#include "engine/sim/simulation.h"
#include "tools/cost/estimate.h"
#include "tools/film/panel_scenes.h"
#include "tools/program/command.h"
#include "tools/program/preview.h"
#include "tools/scene_file/camera_warnings.h"

namespace whorl {
namespace {

/// A scene with panels is run once for each, one after the other.
std::vector<Estimate> estimates_of_runs(const SceneFile& file, const Estimate& alone) {
    if (file.scene.panels.empty()) return {alone};
    std::vector<Estimate> runs;
    for (const SceneFile& panel : panel_scenes(file)) runs.push_back(estimate(panel));
    return runs;
}

FilmCost film_cost(const std::vector<Estimate>& runs) {
    FilmCost sum;
    for (const Estimate& e : runs)
        sum.wall += e.film, sum.simulate += e.film_simulate, sum.surface += e.film_surface, sum.draw += e.film_draw;
    return sum;
}

int plan(const Options& options) {
    set_threads(options.threads);
    const SceneFile file = read_scene_file(options);
    Plan plan = make_plan(file);
    const Simulation simulation(file.scene, plan);
    check_probes(simulation);
    if (!options.json && (!find_calibration(file) || !file.scene.panels.empty()))
        fmt::print(stderr, "measuring the cost of steps and pictures: some moments of the film with larger particles ...\n");
    const Calibration calibration = calibrate(file, plan, simulation);
    const Estimate cost = estimate(file, plan, simulation, calibration);
    const std::vector<Estimate> runs = estimates_of_runs(file, cost);
    if (!file.scene.panels.empty()) plan.warnings = warnings_of(file);  // of what is run
    const auto less = [](const Estimate& a, const Estimate& b) { return a.memory < b.memory; };
    const Estimate& largest = *std::max_element(runs.begin(), runs.end(), less);
    if (const std::string warning = memory_warning(largest, free_memory()); !warning.empty()) plan.warnings.push_back(warning);
    const Preview preview{file, plan, simulation, PreviewCost{calibration, cost, film_cost(runs)}};
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

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/probes/comparison.h"
#include "engine/scene/plan.h"
#include "engine/scene/scene.h"
#include "tools/film/exports.h"
#include "tools/film/panel_scenes.h"
#include "tools/film/run.h"
#include "tools/program/command.h"
#include "tools/program/preview.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

/// Prints what the run would do, without simulating.
int dry_run(const RunRequest& request) {
    Plan plan = make_plan(request.file);
    plan.warnings = warnings_of(request.file);
    const Simulation simulation(request.file.scene, plan);
    check_probes(simulation);
    const int frames = request.frames.value_or(frame_count(request.file.scene));
    print_preview({.file = request.file, .plan = plan, .simulation = simulation, .frames = frames, .folder = request.folder}, request.json);
    return exit_done;
}

int render(const Options& options) {
    set_threads(options.threads);
    RunRequest request{read_scene_file(options), options.out, options.frames, options.no_draw, options.quiet, options.json};
    if (options.out.empty()) request.folder = std::filesystem::path("out") / request.file.scene.name;
    if (request.frames) request.frames = std::min(*request.frames, frame_count(request.file.scene));
    request.overwrite = options.overwrite;
    if (request.no_draw) export_raw(request.file.scene);
    if (options.dry_run) return dry_run(request);
    return request.file.scene.panels.empty() ? run_scene(request) : run_panels(request, false);
}

}  // namespace

void add_render(CLI::App& program, Job& chosen) {
    const auto [app, o] = add_command(
        program, chosen, "render", "simulate and draw a scene: images, video and diagnostics in a run folder", render,
        "A folder with a run is refused unless --overwrite is given; a folder with other files is always refused. Ctrl-C saves the state.\n"
        "Examples:\n"
        "  whorl render honey_coil\n"
        "  whorl render honey_coil --quality draft --until 1 --size 640x360 --out runs/try\n"
        "  whorl render dam_break --no-images --set fluid.spacing=0.01");
    add_options(app, o,
                {&o.scene, &o.set, &o.with, &o.out, &o.overwrite, &o.until, &o.frames, &o.size, &o.fps, &o.quality, &o.no_video,
                 &o.no_images, &o.no_draw, &o.exports, &o.threads, &o.seed, &o.dry_run, &o.quiet, &o.json});
}

}  // namespace whorl

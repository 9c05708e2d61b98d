#include <CLI/CLI.hpp>
#include <memory>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/scene/scene.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/program/command.h"

namespace whorl {
namespace {

/// When the run is to end now [s]; nothing if it keeps its end. @throws InputError
std::optional<double> wanted_end(const Options& options, const Scene& scene) {
    if (options.until && options.frames)
        throw InputError({"--frames", 0, 0}, "--until and --frames both say when the run ends", "give one of them");
    if (!options.frames) return options.until;
    if (*options.frames < 2) throw InputError({"--frames", 0, 0}, "a resumed run has a second frame", "", "allowed: at least 2");
    return frame_time(scene, *options.frames);
}

int resume(const Options& options) {
    set_threads(options.threads);
    RunFolder::existing(options.folder);  // throws if there is no run, or another process works in it
    RunRequest request;
    request.file = read_scene_file(options.folder / "scene.resolved.toml");
    if (const auto until = wanted_end(options, request.file.scene)) {
        Options with_end;
        with_end.scene = (options.folder / "scene.resolved.toml").string();
        with_end.until = until;
        request.file = read_scene_file(with_end);
        request.frames = frame_count(request.file.scene);
    }
    if (options.no_video) request.file.scene.output.video = false;
    request.folder = options.folder;
    request.no_draw = options.no_draw, request.force = options.force, request.quiet = options.quiet, request.json = options.json;
    if (request.no_draw) export_raw(request.file.scene);
    if (!request.file.scene.panels.empty()) return run_panels(request, true);
    resume_from_newest(request);
    return run_scene(request);
}

}  // namespace

void add_resume(CLI::App& program, Job& chosen) {
    const auto options = std::make_shared<Options>();
    CLI::App* app = program.add_subcommand("resume", "continue a run from its last checkpoint, to the same result as without a stop");
    add_options(*app, *options,
                {Option::folder, Option::until, Option::frames, Option::force, Option::no_video, Option::no_draw, Option::threads,
                 Option::quiet, Option::json});
    app->footer(
        "With --until or --frames a run ends later (or earlier) than it was to, also one that is done. scene.resolved.toml says so then, "
        "and\n"
        "rendering that file makes the same film.\n"
        "Examples:\n"
        "  whorl resume out/honey_coil\n"
        "  whorl resume out/honey_coil --until 8         a longer film");
    app->callback([options, &chosen] { chosen = [options] { return resume(*options); }; });
}

}  // namespace whorl

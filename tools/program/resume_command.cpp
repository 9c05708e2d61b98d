
#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/scene/scene.h"
#include "tools/film/exports.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/program/command.h"

namespace whorl {
namespace {

/// New end of the run from --until or --frames [s]; empty if neither is given. @throws InputError
std::optional<double> wanted_end(const Options& options, const Scene& scene) {
    if (options.until && options.frames)
        throw InputError({"--frames", 0, 0}, "--until and --frames both set the end of the run", "use only one of them");
    if (!options.frames) return options.until;
    if (*options.frames < 2) throw InputError({"--frames", 0, 0}, "a resumed run has at least 2 frames", "", "allowed: at least 2");
    return frame_time(scene, *options.frames);
}

int resume(const Options& options) {
    set_threads(options.threads);
    RunFolder::existing(options.folder);  // throws if there is no run, or another process works in it
    Options resolved;
    resolved.scene = (options.folder / "scene.resolved.toml").string();
    RunRequest request{read_scene_file(resolved), options.folder};
    if (const auto until = wanted_end(options, request.file.scene)) {
        resolved.until = until;
        request.file = read_scene_file(resolved);
        request.frames = frame_count(request.file.scene);
    }
    if (options.no_video) request.file.scene.output.video = false;
    request.no_draw = options.no_draw, request.force = options.force, request.quiet = options.quiet, request.json = options.json;
    if (request.no_draw) export_raw(request.file.scene);
    if (!request.file.scene.panels.empty()) return run_panels(request, true);
    resume_from_newest(request);
    return run_scene(request);
}

}  // namespace

void add_resume(CLI::App& program, Job& chosen) {
    const auto [app, o] = add_command(
        program, chosen, "resume", "continue a run from its last checkpoint, with the same result as an uninterrupted run", resume,
        "--until or --frames set a new end, also for a finished run. The new end is stored in scene.resolved.toml; rendering that file "
        "gives\n"
        "the same run.\n"
        "Examples:\n"
        "  whorl resume out/honey_coil\n"
        "  whorl resume out/honey_coil --until 8         continue until 8 s");
    add_options(app, o, {&o.folder, &o.until, &o.frames, &o.force, &o.no_video, &o.no_draw, &o.threads, &o.quiet, &o.json});
}

}  // namespace whorl

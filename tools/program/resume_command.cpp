#include <CLI/CLI.hpp>
#include <memory>

#include "engine/core/parallel.h"
#include "tools/film/panels.h"
#include "tools/film/resume_run.h"
#include "tools/film/run_folder.h"
#include "tools/program/command.h"

namespace whorl {
namespace {

struct ResumeOptions {
    Options shared;
    std::filesystem::path folder;
};

int resume(const ResumeOptions& options) {
    set_threads(options.shared.threads);
    if (!is_run_folder(options.folder)) RunFolder::existing(options.folder);  // throws, saying what is missing
    RunRequest request;
    request.file = read_scene_file(options.folder / "scene.resolved.toml");
    request.folder = options.folder;
    request.frames = options.shared.frames;
    request.quiet = options.shared.quiet;
    request.json = options.shared.json;
    if (!request.file.scene.panels.empty()) return run_panels(request, PanelRuns::resumed);
    resume_from_newest(request);
    return run_scene(request);
}

}  // namespace

void add_resume(CLI::App& program, Job& chosen) {
    const auto options = std::make_shared<ResumeOptions>();
    CLI::App* app = program.add_subcommand("resume", "go on from a run's newest checkpoint, to the same result as if it had never stopped");
    app->add_option("folder", options->folder, "the run folder, as in out/honey_coil")->required()->type_name("RUN_FOLDER");
    add_options(*app, options->shared, {Option::frames, Option::threads, Option::quiet, Option::json});
    app->footer("Example:\n  whorl resume out/honey_coil");
    app->callback([options, &chosen] { chosen = [options] { return resume(*options); }; });
}

}  // namespace whorl

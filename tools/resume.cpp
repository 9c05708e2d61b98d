#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/scene/read.h"
#include "tools/command.h"
#include "tools/run/run.h"
#include "tools/run/run_folder.h"

namespace whorl {
namespace {

struct ResumeOptions {
    Options shared;
    std::filesystem::path folder;
};

/// @throws InputError with every setting that decides the simulation and is not what it was
void check_settings(const Checkpoint& checkpoint, const Scene& now, const std::filesystem::path& scene_file) {
    const Scene before = read_resolved(checkpoint.scene, scene_file.string()).scene;
    std::vector<Problem> problems;
    for (const std::string& difference : differences(before, now)) problems.push_back({{scene_file.string(), 0, 0}, difference, "", ""});
    if (problems.empty()) return;
    problems.insert(problems.begin(), {{scene_file.string(), 0, 0},
                                       "the checkpoint is of other settings",
                                       "put them back to go on, or render this file as a new run", ""});
    throw InputError(problems);
}

int resume(const ResumeOptions& options) {
    set_threads(options.shared.threads);
    if (!is_run_folder(options.folder)) RunFolder::existing(options.folder);  // throws, saying what is missing
    std::vector<std::string> damaged;
    std::optional<Checkpoint> checkpoint = newest_checkpoint(options.folder, damaged);
    for (const std::string& line : damaged) fmt::print(stderr, "whorl: {}\n", line);
    if (!checkpoint)
        throw InputError({options.folder.string(), 0, 0}, "there is no sound checkpoint to go on from", "render the scene anew",
                         "checkpoints appear every output.checkpoint_every seconds and on Ctrl-C");
    if (checkpoint->build != build_id())
        throw InputError({options.folder.string(), 0, 0},
                         fmt::format("the checkpoint was written by another build ({}; this is {}), which would not go on with the same bits",
                                     checkpoint->build, build_id()),
                         "use the build that wrote it, or render the scene anew");

    RunRequest request;
    const std::filesystem::path scene_file = options.folder / "scene.resolved.toml";
    request.file = read_scene_file(scene_file);
    check_settings(*checkpoint, request.file.scene, scene_file);
    request.folder = options.folder;
    // A run that --frames had cut short keeps its end; one that was to reach time.end goes there, also where time.end has moved.
    const int whole = frame_count(read_resolved(checkpoint->scene, scene_file.string()).scene);
    const int last = checkpoint->frames < whole ? checkpoint->frames : frame_count(request.file.scene);
    request.frames = options.shared.frames.value_or(last);
    request.quiet = options.shared.quiet;
    request.json = options.shared.json;
    request.from = std::move(checkpoint);
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

#include "tools/film/resume_run.h"

#include <fmt/format.h>

#include "engine/core/errors.h"
#include "engine/scene/frame_times.h"
#include "engine/scene/read.h"
#include "engine/scene/scene_difference.h"
#include "engine/scene/write.h"

namespace whorl {
namespace {

/// @throws InputError with every setting that decides the simulation and is not what it was
void check_settings(const Checkpoint& checkpoint, const Scene& now, const std::filesystem::path& scene_file) {
    const Scene before = read_resolved(checkpoint.scene, scene_file.string()).scene;
    std::vector<Problem> problems;
    // What the particles carry from the start on.
    if (before.identities != now.identities || before.ages != now.ages)
        problems.push_back({now.place("output.export"), "points, mesh and vtk need particles that know their number and age", "", ""});
    if (before.grains != now.grains)
        problems.push_back({now.place("look"), "the new look needs other columns of the particles than the run began with", "", ""});
    for (const std::string& difference : differences(before, now)) problems.push_back({{scene_file.string(), 0, 0}, difference, "", ""});
    if (problems.empty()) return;
    problems.insert(problems.begin(), {{scene_file.string(), 0, 0},
                                       "the checkpoint is of other settings",
                                       "put them back to go on, or render this file as a new run",
                                       ""});
    throw InputError(problems);
}

}  // namespace

void resume_from_newest(RunRequest& request) {
    std::vector<std::string> damaged;
    std::optional<Checkpoint> checkpoint = newest_checkpoint(request.folder, damaged);
    for (const std::string& line : damaged) fmt::print(stderr, "whorl: {}\n", line);
    if (!checkpoint)
        throw InputError({request.folder.string(), 0, 0}, "there is no sound checkpoint to go on from", "render the scene anew",
                         "checkpoints appear every output.checkpoint_every seconds and on Ctrl-C");
    if (checkpoint->build != build_id())
        throw InputError(
            {request.folder.string(), 0, 0},
            fmt::format("the checkpoint was written by another build ({}; this is {}), which would not go on with the same bits",
                        checkpoint->build, build_id()),
            "use the build that wrote it, or render the scene anew");

    const std::filesystem::path scene_file = request.folder / "scene.resolved.toml";
    check_settings(*checkpoint, request.file.scene, scene_file);
    // A run that --frames had cut short keeps its end; one that was to reach time.end goes there, also where time.end has moved.
    const int whole = frame_count(read_resolved(checkpoint->scene, scene_file.string()).scene);
    const int last = checkpoint->frames < whole ? checkpoint->frames : frame_count(request.file.scene);
    request.frames = request.frames.value_or(last);
    request.from = std::move(checkpoint);
}

}  // namespace whorl

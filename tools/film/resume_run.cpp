#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "engine/core/errors.h"
#include "engine/scene/plan.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_difference.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"

namespace whorl {
namespace {

/// @throws InputError with every changed setting that affects the simulation
void check_settings(const Checkpoint& checkpoint, const Scene& now, const std::filesystem::path& scene_file) {
    const Scene before = read_resolved(checkpoint.scene, scene_file.string()).scene;
    std::vector<Problem> problems;
    // A run has these columns from its start or not at all.
    if (before.identities != now.identities || before.ages != now.ages)
        problems.push_back(
            {now.place(now.any_flux() == before.any_flux() ? "output.export" : "probe"),
             "the exports points, mesh and vtk and flux probes need other columns of the particles (number, age) than the run began with",
             "", ""});
    if (before.grains != now.grains || before.foam != now.foam)
        problems.push_back({now.place("look"), "the new look needs other columns of the particles than the run began with", "", ""});
    for (const std::string& difference : differences(before, now)) problems.push_back({{scene_file.string(), 0, 0}, difference, "", ""});
    if (problems.empty()) return;
    problems.insert(problems.begin(), {{scene_file.string(), 0, 0},
                                       "the checkpoint was written with other settings",
                                       "restore them to continue, or render this file as a new run",
                                       ""});
    throw InputError(problems);
}

/// @throws InputError with every mesh, image and table that was edited after the run read it
void check_inputs(const Checkpoint& checkpoint, const SceneFile& now) {
    std::vector<Problem> problems;
    for (const auto& [file, sum] : input_checksums(now))
        if (const auto before = checkpoint.inputs.find(file); before != checkpoint.inputs.end() && before->second != sum)
            problems.push_back(
                {{file, 0, 0}, "was edited after the run began", "restore it, or continue with the edited file: --force", ""});
    if (!problems.empty()) throw InputError(problems);
}

/// Choices of the plan that affect the simulation. The preconditioner is excluded: the plan chooses it by the number of pressing particles.
std::vector<UsedKey> decisions(const Plan& plan) {
    std::vector<UsedKey> all;
    for (const Choice& c : plan.choices)
        if (c.key != "viscosity matrix" && c.key != "pressure.preconditioner") all.push_back({{c.key, Value(c.value)}});
    all.push_back({{"speed of sound", Value(plan.sound_speed)}});
    all.push_back({{"artificial viscosity", Value(plan.artificial_viscosity)}});
    all.push_back({{"largest viscosity", Value(plan.largest_viscosity)}});
    return all;
}

/// A run that is continued to a later time.end must be bit-identical to a run of the longer scene. @throws InputError if the later end
/// changes the plan
void check_plan(const Scene& before, const Scene& now, const std::filesystem::path& scene_file) {
    if (before.time.end == now.time.end) return;
    std::vector<Problem> problems;
    for (const KeyDifference& d : differences(decisions(make_plan(before)), decisions(make_plan(now))))
        problems.push_back({{scene_file.string(), 0, 0}, d.text(), "", ""});
    if (problems.empty()) return;
    problems.insert(problems.begin(), {{scene_file.string(), 0, 0},
                                       fmt::format("with time.end = {:g} s the plan chooses other models or constants than with {:g} s",
                                                   now.time.end, before.time.end),
                                       "set these keys in the scene and render it again",
                                       ""});
    throw InputError(problems);
}

InputError no_sound_checkpoint(const std::filesystem::path& folder) {
    return {{folder.string(), 0, 0},
            "no valid checkpoint to continue from",
            "render the scene again",
            "checkpoints are written every output.checkpoint_every seconds and on Ctrl-C"};
}

/// Restarts a run that was stopped before its first checkpoint. @throws InputError if the run has ended or must have had a checkpoint, or
/// if the folder contains only images of another run
void begin_again(RunRequest& request) {
    const nlohmann::json report = report_of(request.folder);
    const std::string status = report.value("status", "");
    if (const std::string source = report.value("drawn_from", ""); !source.empty())
        throw InputError({request.folder.string(), 0, 0}, "contains images that were drawn from another run",
                         is_run_folder(source) ? "continue that run: whorl resume " + source : "that run is no longer in " + source);
    if (status == "done" || status == "diverged")
        throw InputError({request.folder.string(), 0, 0},
                         fmt::format("the run {} and has no checkpoint to continue from", status == "done" ? "is done" : "diverged"),
                         "render the scene again");
    if (report.value("frames", 0) > 0 && status != "running") throw no_sound_checkpoint(request.folder);
    // As with a checkpoint, an end set by --frames stays unless the scene's end has changed.
    const int all = frame_count(request.file.scene), planned = report.value("frames_planned", all);
    const bool cut = planned > 0 && planned < all && report.value("frames_of_scene", all) == all;
    request.frames = request.frames.value_or(cut ? planned : all);
    request.overwrite = true;
    tell_note("no checkpoint yet: the run restarts", request.json);
}

}  // namespace

void check_end(const std::filesystem::path& folder, const Scene& scene, int made, int wanted) {
    if (wanted < made)
        throw InputError({folder.string(), 0, 0},
                         fmt::format("the run has already reached frame {} ({:g} s)", made, frame_time(scene, made)), "",
                         "allowed: a later end; render the scene again for a shorter film");
}

void check_pictures(const std::filesystem::path& folder, const Scene& scene, int made) {
    for (int frame = 1; frame <= made; ++frame) {
        if (has_picture(folder, frame)) continue;
        const bool exported = std::filesystem::exists(frame_file(folder, frame));
        throw InputError({folder.string(), 0, 0}, fmt::format("the run has no image of frame {}", frame),
                         exported ? fmt::format("draw it first: whorl draw {}; or continue with --no-draw", folder.string())
                                  : "continue without images: --no-draw");
    }
    if (made > 0) read_picture(folder, 1, scene.output.size[0], scene.output.size[1]);
}

void resume_from_newest(RunRequest& request) {
    if (!has_checkpoint(request.folder)) return begin_again(request);
    std::vector<std::string> damaged;
    std::optional<Checkpoint> checkpoint = newest_checkpoint(request.folder, damaged);
    for (const std::string& line : damaged) fmt::print(stderr, "whorl: {}\n", line);
    if (!checkpoint) throw no_sound_checkpoint(request.folder);
    if (checkpoint->build != build_id())
        throw InputError(
            {request.folder.string(), 0, 0},
            fmt::format("the checkpoint was written by another build ({}; this is {}), which would not continue bit-identically",
                        checkpoint->build, build_id()),
            "use the build that wrote it, or render the scene again");

    const std::filesystem::path scene_file = request.folder / "scene.resolved.toml";
    check_settings(*checkpoint, request.file.scene, scene_file);
    if (!request.force) check_inputs(*checkpoint, request.file);
    const Scene before = read_resolved(checkpoint->scene, scene_file.string()).scene;
    check_plan(before, request.file.scene, scene_file);
    // A run that --frames shortened keeps its end unless time.end has changed.
    const bool cut = checkpoint->frames < frame_count(before) && before.time.end == request.file.scene.time.end;
    request.frames = request.frames.value_or(cut ? checkpoint->frames : frame_count(request.file.scene));
    check_end(request.folder, before, checkpoint->frame, *request.frames);
    if (request.file.scene.output.images && !request.no_draw) check_pictures(request.folder, request.file.scene, checkpoint->frame);
    request.from = std::move(checkpoint);
}

}  // namespace whorl

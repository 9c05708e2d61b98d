#include <CLI/CLI.hpp>
#include <charconv>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/program/command.h"
#include "tools/scene_file/camera_warnings.h"
#include "tools/scene_file/options.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

struct DrawOptions {
    Options shared;
    std::string frames;  ///< "12", "1-100"
};

/// "12" is frame 12 alone, "1-100" all of these. @throws InputError
void read_frames(const std::string& text, RedrawRequest& request) {
    if (text.empty()) return;
    int first = 0, last = 0;
    const char* const end = text.data() + text.size();
    auto number = std::from_chars(text.data(), end, first);
    last = first;
    if (number.ec == std::errc() && number.ptr != end && *number.ptr == '-') number = std::from_chars(number.ptr + 1, end, last);
    if (number.ec != std::errc() || number.ptr != end || first < 1 || last < first)
        throw InputError({"--frames", 0, 0}, "\"" + text + "\" names no frames", "", "one number, or two as in 1-100");
    request.first = first, request.last = last;
}

/// The change that decides the simulation, as it was given; "--set" where it takes several.
std::string deciding(const SceneFile& before, const std::vector<KeyValue>& changes) {
    for (const KeyValue& change : changes) try {
            if (decides(before, changed(before, {change}))) return change.value.place.file;
        } catch (const InputError&) {  // it needs another key as well
        }
    return "--set";
}

int draw(const DrawOptions& options) {
    set_threads(options.shared.threads);
    const std::filesystem::path& folder = options.shared.folder;
    // Ranges may be drawn at the same time, and other looks of one run into other folders.
    std::error_code none;
    const bool elsewhere = !options.shared.out.empty() && !std::filesystem::equivalent(options.shared.out, folder, none);
    const auto hold = options.frames.empty() ? RunFolder::Hold::alone : RunFolder::Hold::shared;
    std::optional<RunFolder> held(RunFolder::existing(folder, RunFolder::Hold::looking));
    const std::string status = report_of(folder).value("status", "running");
    const bool goes_on = !held->is_held() && status == "running";
    if (goes_on && !elsewhere) {
        check_images_free(folder, folder);
        held.emplace(RunFolder::any(folder / "frames"));
    } else if (!elsewhere) {
        held.reset();
        held.emplace(RunFolder::existing(folder, hold));
    }
    if (goes_on) tell_note("the run continues: its frames are drawn as they come, until it ends", false);
    Options own = options.shared;
    own.scene = (folder / "scene.resolved.toml").string();
    const SceneFile before = read_scene_file(own.scene);
    RedrawRequest request;
    own.set.clear();
    std::vector<KeyValue> changes;
    for (const std::string& text : options.shared.set) changes.push_back(parse_change(text));
    request.file = changed(read_scene_file(own), changes);
    if (!request.file.scene.panels.empty())
        throw InputError({folder.string(), 0, 0}, "this is a film of several panels",
                         "draw each of them, as in whorl draw " + (folder / "panels/1").string() +
                             ", then put them together: whorl resume " + folder.string());
    if (decides(before, request.file))
        throw InputError({deciding(before, changes), 0, 0}, "only what the pictures show can be changed, the simulation is over",
                         "render the scene again", "keys of [look], [camera], [surface] and [output]");
    request.run = folder;
    request.out = elsewhere ? options.shared.out : folder;
    if (!elsewhere) request.made = before.scene.output.exports;
    request.goes_on = goes_on, request.overwrite = options.shared.overwrite, request.quiet = options.shared.quiet;
    read_frames(options.frames, request);
    request.file.scene.output.images = true;  // also of a run that made none
    if (!request.quiet)
        for (const std::string& warning : camera_warnings(request.file)) std::fprintf(stderr, "warning: %s\n", warning.c_str());
    return redraw(request);
}

}  // namespace

void add_draw(CLI::App& program, Job& chosen) {
    const auto options = std::make_shared<DrawOptions>();
    CLI::App* app =
        program.add_subcommand("draw", "draw a run's pictures again from the frames it exported (--export raw), without simulating");
    app->add_option("--frames", options->frames, "one frame, or a range as in 1-100 (default: all)")->type_name("A-B");
    add_options(
        *app, options->shared,
        {Option::folder, Option::set, Option::out, Option::overwrite, Option::size, Option::no_video, Option::threads, Option::quiet});
    app->get_option("--out")->description("folder for the pictures (default: the run's own, where they replace the old ones)");
    app->footer(
        "Keys of the look, the camera and the surface may be others than the run's.\n"
        "Examples:\n"
        "  whorl render honey_coil --export raw\n"
        "  whorl draw out/honey_coil --set look.material=chocolate --out out/chocolate_coil\n"
        "  whorl draw out/honey_coil --frames 40-60");
    app->callback([options, &chosen] { chosen = [options] { return draw(*options); }; });
}

}  // namespace whorl

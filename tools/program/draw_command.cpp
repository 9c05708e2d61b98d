#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/program/command.h"
#include "tools/scene_file/options.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

struct DrawOptions : Options {
    std::string range;  ///< "12", "1-100"
};

/// Reads --frames: "12" is frame 12, "1-100" the frames 1 to 100. @throws InputError
void read_frames(const std::string& text, RedrawRequest& request) {
    if (text.empty()) return;
    int first = 0, last = 0;
    const char* const end = text.data() + text.size();
    auto number = std::from_chars(text.data(), end, first);
    last = first;
    if (number.ec == std::errc() && number.ptr != end && *number.ptr == '-') number = std::from_chars(number.ptr + 1, end, last);
    if (number.ec != std::errc() || number.ptr != end || first < 1 || last < first)
        throw InputError({"--frames", 0, 0}, "\"" + text + "\" is not a frame or a range of frames", "",
                         "allowed: a number, or a range as in 1-100");
    request.first = first, request.last = last;
}

/// Whether the frames of `before` cannot show `now`. They can show other looks of solids and nozzles, but not a solid that was hidden.
bool needs_simulation(SceneFile before, const SceneFile& now) {
    const auto take = [](auto& things, const auto& from) {
        for (std::size_t k = 0; k < std::min(things.size(), from.size()); ++k)
            if (things[k].appearance.show == from[k].appearance.show) things[k].appearance = from[k].appearance;
    };
    take(before.scene.solids, now.scene.solids), take(before.scene.emitters, now.scene.emitters);
    return decides(before, now);
}

/// The first change that affects the simulation by itself, as the user gave it; "--set" if only several together do.
std::string deciding(const SceneFile& before, const std::vector<KeyValue>& changes) {
    for (const KeyValue& change : changes) try {
            if (needs_simulation(before, changed(before, {change}))) return change.value.place.file;
        } catch (const InputError&) {  // valid only together with another change
        }
    return "--set";
}

int draw(const DrawOptions& options) {
    set_threads(options.threads);
    const std::filesystem::path& folder = options.folder;
    // Several processes may draw ranges of frames into the run's folder at the same time, or other looks into other folders.
    std::error_code none;
    const bool elsewhere = !options.out.empty() && !std::filesystem::equivalent(options.out, folder, none);
    const auto hold = options.range.empty() ? RunFolder::Hold::alone : RunFolder::Hold::shared;
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
    Options own = options;
    own.scene = (folder / "scene.resolved.toml").string();
    const SceneFile before = read_scene_file(own.scene);
    RedrawRequest request;
    own.set.clear();
    std::vector<KeyValue> changes;
    for (const std::string& text : options.set) changes.push_back(parse_change(text));
    request.file = changed(read_scene_file(own), changes);
    if (!request.file.scene.panels.empty())
        throw InputError(
            {folder.string(), 0, 0}, "the run has several panels",
            "draw each panel, as in whorl draw " + (folder / "panels/1").string() + ", then combine them: whorl resume " + folder.string());
    if (needs_simulation(before, request.file))
        throw InputError({deciding(before, changes), 0, 0}, "the change affects the simulation, which is over", "render the scene again",
                         "allowed: keys of [look], [camera], [surface] and [output], and the material, colour, roughness, metallic and "
                         "texture of a solid or an emitter");
    const std::vector<Appearance> old = looks_of_solids(before.scene), looks = looks_of_solids(request.file.scene);
    for (std::size_t k = 0; k < looks.size(); ++k)
        if (looks[k] != old[k]) request.looks[k] = looks[k];
    request.run = folder;
    request.out = elsewhere ? options.out : folder;
    if (!elsewhere) request.made = before.scene.output.exports;
    request.goes_on = goes_on, request.overwrite = options.overwrite, request.quiet = options.quiet;
    read_frames(options.range, request);
    request.file.scene.output.images = true;  // even if the run made none
    if (!request.quiet)
        for (const std::string& warning : camera_warnings(request.file)) std::fprintf(stderr, "warning: %s\n", warning.c_str());
    return redraw(request);
}

}  // namespace

void add_draw(CLI::App& program, Job& chosen) {
    const auto [app, o] =
        add_command(program, chosen, "draw", "draw a run's images again from its exported frames (--export raw), without simulating", draw,
                    "--set may change keys of [look], [camera], [surface] and [output], and the looks of solids and emitters.\n"
                    "Examples:\n"
                    "  whorl render honey_coil --export raw\n"
                    "  whorl draw out/honey_coil --set look.material=chocolate --out out/chocolate_coil\n"
                    "  whorl draw out/honey_coil --set solid[0].material=wood --out out/wood\n"
                    "  whorl draw out/honey_coil --frames 40-60");
    app.add_option("--frames", o.range, "one frame, or a range as in 1-100 (default: all)")->type_name("A-B");
    add_options(app, o, {&o.folder, &o.set, &o.out, &o.overwrite, &o.size, &o.no_video, &o.threads, &o.quiet});
    app.get_option("--out")->description("folder for the images (default: the run's folder, where they replace the old images)");
}

}  // namespace whorl

#include "tools/film/panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/core/version.h"
#include "engine/core/whole_file.h"
#include "engine/io/files.h"
#include "engine/scene/frame_times.h"
#include "render/image/arrange.h"
#include "render/video/encoder.h"
#include "tools/film/colour_range.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/resume_run.h"
#include "tools/film/run_folder.h"
#include "tools/process/exit_codes.h"
#include "tools/process/usage.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int gap = 4;  ///< pixels between panels

fs::path panel_folder(const fs::path& run_folder, std::size_t panel) { return run_folder / "panels" / std::to_string(panel + 1); }

std::string name_of(const PanelKeys& panel, std::size_t k) { return panel.label.empty() ? std::to_string(k + 1) : panel.label; }

/// The range of each map that several panels draw with: one that holds them all. Places the fluid of every panel for it.
/// @throws InputError where a panel's scene is impossible
void share_ranges(std::vector<SceneFile>& panels) {
    std::map<std::pair<std::string, std::string>, std::array<float, 2>> shared;
    const auto wants = [](const LookOptions& look) { return shows_field(look) && look.range[0] == look.range[1]; };
    for (const SceneFile& panel : panels) {
        const Simulation start(panel.scene, make_plan(panel.scene));  // an impossible scene ends here, before anything is written
        if (!wants(panel.look)) continue;
        const auto range = film_range(panel.look, start);
        const auto [it, first] = shared.try_emplace({panel.look.field, panel.look.colour_map}, range);
        it->second = {std::min(it->second[0], range[0]), std::max(it->second[1], range[1])};
    }
    for (SceneFile& panel : panels)
        if (wants(panel.look)) panel.look.range = shared.at({panel.look.field, panel.look.colour_map});
}

/// What a panel's own run.json says; an empty object where it has not begun.
Json state_of(const fs::path& panel) {
    std::ifstream in(panel / "run.json");
    Json run = Json::parse(in, nullptr, false);
    return run.is_object() ? run : Json::object();
}

class PanelFilm {
public:
    PanelFilm(const RunRequest& request, PanelRuns how)
        : request_(request), scene_(request.file.scene), scenes_(panel_scenes(request.file)),
          folder_(how == PanelRuns::fresh ? RunFolder::fresh(request.folder) : RunFolder::existing(request.folder)) {
        if (how == PanelRuns::fresh) write_text(folder_.path() / "scene.resolved.toml", resolved_toml(request.file));
    }

    int go() {
        write_report("running", "");
        for (std::size_t k = 0; k < scenes_.size(); ++k) {
            const int code = run(k);
            if (code == exit_interrupted) {
                write_report("interrupted", "go on with: whorl resume " + folder_.path().string());
                std::fprintf(stderr, "whorl: panel %zu of %zu was interrupted; go on with all of them: whorl resume %s\n", k + 1,
                             scenes_.size(), folder_.path().c_str());
                return code;
            }
            if (code != exit_done) failed_ = k;
        }
        const int frames = least_frames();
        if (scene_.output.frames && frames > 0) film(frames);
        const std::string status = failed_ ? "diverged" : "done";
        write_report(status, failed_ ? "panel " + name_of(scene_.panels[*failed_], *failed_) + " diverged" : "");
        if (!request_.quiet && !request_.json)
            std::fprintf(stderr, "%d frames of %zu panels: %s\n", frames, scenes_.size(), folder_.path().c_str());
        return failed_ ? exit_failed : exit_done;
    }

private:
    int run(std::size_t k) const {
        RunRequest panel;
        panel.file = scenes_[k];
        panel.folder = panel_folder(folder_.path(), k);
        panel.frames = request_.frames;
        panel.quiet = request_.quiet, panel.json = request_.json;
        const std::string status = state_of(panel.folder).value("status", "");
        if (status == "done") return exit_done;
        if (status == "diverged") return exit_failed;
        if (!request_.quiet && !request_.json)
            std::fprintf(stderr, "panel %zu of %zu: %s\n", k + 1, scenes_.size(), name_of(scene_.panels[k], k).c_str());
        std::vector<std::string> damaged;
        if (!status.empty() && newest_checkpoint(panel.folder, damaged)) resume_from_newest(panel);
        return run_scene(panel);
    }

    /// Frames that every panel has.
    int least_frames() const {
        int least = 1 << 30;
        for (std::size_t k = 0; k < scenes_.size(); ++k)
            least = std::min(least, state_of(panel_folder(folder_.path(), k)).value("frames", 0));
        return least;
    }

    void film(int frames) const {
        fs::create_directories(folder_.path() / "frames");
        const int width = scene_.output.size[0], height = scene_.output.size[1];
        std::optional<VideoEncoder> encoder;
        if (scene_.output.video) encoder.emplace(folder_.path() / (scene_.name + ".mp4"), width, height, VideoOptions{scene_.time.fps, 18});
        for (int frame = 1; frame <= frames; ++frame) {
            std::vector<Image> images;
            for (std::size_t k = 0; k < scenes_.size(); ++k)
                images.push_back(read_png(picture_file(panel_folder(folder_.path(), k), frame)));
            const Image whole = side_by_side(images, panel_columns(scene_), gap, width, height);
            write_png(picture_file(folder_.path(), frame), whole);
            if (encoder) encoder->add(whole);
        }
        if (encoder) encoder->finish();
        write_contact_sheet(folder_.path(), frames);
    }

    void write_report(const std::string& status, const std::string& message) const {
        Json panels = Json::array();
        double wall = 0, cpu = 0;
        for (std::size_t k = 0; k < scenes_.size(); ++k) {
            const Json run = state_of(panel_folder(folder_.path(), k));
            wall += run.value("wall_seconds", 0.0), cpu += run.value("cpu_seconds", 0.0);
            panels.push_back({{"label", scene_.panels[k].label},
                              {"folder", "panels/" + std::to_string(k + 1)},
                              {"status", run.value("status", "waiting")},
                              {"frames", run.value("frames", 0)}});
        }
        const Json report{{"whorl", WHORL_VERSION},   {"build", build_id()},
                          {"scene", scene_.name},     {"status", status},
                          {"message", message},       {"panels", panels},
                          {"frames", least_frames()}, {"frames_planned", request_.frames.value_or(frame_count(scene_))},
                          {"wall_seconds", wall},     {"cpu_seconds", cpu}};
        write_text(folder_.path() / "run.json", report.dump(2) + "\n");
    }

    const RunRequest& request_;
    const Scene& scene_;
    std::vector<SceneFile> scenes_;
    RunFolder folder_;
    std::optional<std::size_t> failed_;
};

}  // namespace

int panel_columns(const Scene& scene) {
    const std::size_t panels = scene.panels.size();
    if (scene.output.panel_columns) return std::min(*scene.output.panel_columns, static_cast<int>(panels));
    if (scene.domain.dimensions == 3)
        return panels <= 3 ? static_cast<int>(panels) : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(panels))));
    // A flow in the plane is seen whole: the columns that make it largest.
    const Vec3d size = scene.domain.max - scene.domain.min;
    const auto scale = [&](int columns) {
        const int rows = (static_cast<int>(panels) + columns - 1) / columns;
        return std::min(scene.output.size[0] / (columns * size.x()), scene.output.size[1] / (rows * size.y()));
    };
    int best = 1;
    for (int columns = 2; columns <= static_cast<int>(panels); ++columns)
        if (scale(columns) > scale(best)) best = columns;
    return best;
}

std::vector<SceneFile> panel_scenes(const SceneFile& file) {
    const int count = static_cast<int>(file.scene.panels.size()), columns = panel_columns(file.scene);
    const int rows = (count + columns - 1) / columns;
    SceneFile alone = file;
    alone.scene.panels.clear();
    alone.scene.output.video = false;
    // Even sizes, so that each could be a video of its own.
    alone.scene.output.size = {(file.scene.output.size[0] - (columns - 1) * gap) / columns / 2 * 2,
                               (file.scene.output.size[1] - (rows - 1) * gap) / rows / 2 * 2};
    std::vector<SceneFile> scenes;
    std::vector<Problem> problems;
    for (int k = 0; k < count; ++k) {
        const std::string name = "panel[" + std::to_string(k) + "].set";
        try {
            std::vector<KeyChange> changes;
            for (const std::string& text : file.scene.panels[k].set) {
                changes.push_back(read_change(parse_change(text, name)));
                changes.back().source = file.scene.place(name);
            }
            scenes.push_back(changed(alone, changes));
            if (scenes.back().look.title.empty()) scenes.back().look.title = file.scene.panels[k].label;
            scenes.back().scene.places = file.scene.places;  // what is wrong with it is told by the places in the file
        } catch (const InputError& error) {
            for (Problem problem : error.problems()) {
                problem.place = file.scene.place(name);
                problem.what = name + ": " + problem.what;
                problems.push_back(std::move(problem));
            }
        }
    }
    if (!problems.empty()) throw InputError(std::move(problems));
    share_ranges(scenes);
    return scenes;
}

int run_panels(const RunRequest& request, PanelRuns how) { return PanelFilm(request, how).go(); }

}  // namespace whorl

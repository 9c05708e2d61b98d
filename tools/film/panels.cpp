#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/atomic_file.h"
#include "engine/core/version.h"
#include "engine/io/csv.h"
#include "engine/io/frame.h"
#include "engine/scene/scene.h"
#include "render/flow/slice.h"
#include "render/image/image.h"
#include "render/video/encoder.h"
#include "tools/cost/coarse_run.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/curves.h"
#include "tools/film/panel_scenes.h"
#include "tools/film/progress.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Whether the run draws images.
bool wants_pictures(const RunRequest& request) { return request.file.scene.output.images && !request.no_draw; }

class PanelFilm {
public:
    PanelFilm(const RunRequest& request, bool resumed)
        : request_(request), scene_(request.file.scene), scenes_(panel_scenes(request.file, choice())), cells_(panel_cells(request.file)),
          folder_(resumed ? RunFolder::existing(request.folder) : RunFolder::fresh(request.folder, request.overwrite)) {
        for (std::size_t k = 0; resumed && k < scenes_.size(); ++k) check_resumed(k);
        write_text(folder_.path() / "scene.resolved.toml", resolved_toml(with_choices_of(request.file, scenes_)));
    }

    int make() {
        const InterruptGuard guard;
        write_report("running", "");
        std::string failed;
        for (std::size_t k = 0; k < scenes_.size(); ++k) {
            const int code = run_panel(k);
            if (code == exit_failed) failed = name_of(k);
            if (code == exit_interrupted) return conclude_interrupted(k);
        }
        const int frames = least_frames();
        const bool filmed = wants_pictures(request_) && frames > 0;
        if (filmed) film(frames);
        write_report(failed.empty() ? "done" : "diverged", failed.empty() ? "" : "panel " + failed + " diverged");
        say(fmt::format("{} of {} panels: {}", counted(frames, "frame"), scenes_.size(),
                        (filmed && scene_.output.video ? video() : folder_.path()).string()));
        if (request_.no_draw && scene_.output.images && frames > 0)
            say(fmt::format("draw each panel (whorl draw {}), then combine them: whorl resume {}", panel(0).string(),
                            folder_.path().string()));
        return failed.empty() ? exit_done : exit_failed;
    }

private:
    Choose choice() const {
        if (!scene_.output.images) return {};
        return [watch = watch_coarse_run(request_.quiet || request_.json)](const SceneFile& run, const Simulation& start) {
            return with_choices(run, start, watch);
        };
    }
    void say(const std::string& text) const {
        if (!request_.quiet && !request_.json) fmt::print(stderr, "{}\n", text);
    }

    fs::path panel(std::size_t run) const { return folder_.path() / "panels" / std::to_string(run + 1); }
    fs::path video() const { return folder_.path() / (scene_.name + ".mp4"); }
    int frames_of(std::size_t k) const { return report_of(panel(k)).value("frames", 0); }
    int frames_wanted() const { return request_.frames.value_or(frame_count(scene_)); }
    std::string status_of(std::size_t k) const { return report_of(panel(k)).value("status", "waiting"); }

    enum class Next { nothing, begins, restarts, goes_on };
    /// Next action for a panel.
    Next next_of(std::size_t k) const {
        const std::string status = status_of(k);
        if ((status == "done" && frames_of(k) >= frames_wanted()) || status == "diverged") return Next::nothing;
        // The colour range of a difference depends on all frames of both runs. They are deleted after drawing unless raw is exported.
        if (has_differences() && scene_.output.images && frames_of(k) > 0 && !fs::exists(frame_file(panel(k), 1))) return Next::restarts;
        // If all checkpoints are damaged, resuming fails and leaves the panel untouched for repair.
        return has_checkpoint(panel(k)) ? Next::goes_on : Next::begins;
    }

    /// @throws InputError if a panel cannot continue, or if the video needs an image of a finished panel that is missing or of another size
    void check_resumed(std::size_t k) const {
        check_end(folder_.path(), scene_, frames_of(k), frames_wanted());
        const Next next = next_of(k);
        RunRequest panel = request_of(k);
        if (next == Next::goes_on) resume_from_newest(panel);
        if (next == Next::nothing && wants_pictures(request_)) check_pictures(panel.folder, scenes_[k].scene, frames_of(k));
    }

    /// Label of the run's panel, or the number of the run if there is none.
    std::string name_of(std::size_t run) const {
        const std::string& label = scene_.panels[panel_of(run)].label;
        return label.empty() ? std::to_string(run + 1) : label;
    }
    std::size_t panel_of(std::size_t run) const {
        const auto is_it = [&](const PanelCell& cell) { return cell.run == static_cast<int>(run); };
        return static_cast<std::size_t>(std::find_if(cells_.begin(), cells_.end(), is_it) - cells_.begin());
    }
    bool has_differences() const {
        return std::any_of(cells_.begin(), cells_.end(), [](const PanelCell& cell) { return cell.run < 0; });
    }

    RunRequest request_of(std::size_t k) const {
        RunRequest panel = request_;
        panel.file = scenes_[k], panel.folder = this->panel(k), panel.overwrite = true;
        return panel;
    }

    /// @return as run_scene()
    int run_panel(std::size_t k) const {
        const Next next = next_of(k);
        if (next == Next::nothing) return status_of(k) == "done" ? exit_done : exit_failed;
        const char* const why = ", from the start: a difference needs all frames, but they were deleted (--export raw keeps them)";
        say(fmt::format("panel {} of {}: {}{}", k + 1, scenes_.size(), name_of(k), next == Next::restarts ? why : ""));
        RunRequest panel = request_of(k);
        if (next == Next::goes_on) resume_from_newest(panel);
        return run_scene(panel);
    }

    int conclude_interrupted(std::size_t k) const {
        const std::string go_on = "whorl resume " + folder_.path().string() + (request_.no_draw ? " --no-draw" : "");
        write_report("interrupted", "continue with: " + go_on);
        fmt::print(stderr, "whorl: panel {} of {} was interrupted; continue all of them with:  {}\n", k + 1, scenes_.size(), go_on);
        return exit_interrupted;
    }

    /// Number of frames that every panel has.
    int least_frames() const {
        int least = std::numeric_limits<int>::max();
        for (std::size_t k = 0; k < scenes_.size(); ++k) least = std::min(least, frames_of(k));
        return least;
    }

    /// Folder of a cell's images.
    fs::path pictures_of(std::size_t k) const {
        const int run = cells_[k].run;
        return run >= 0 ? panel(static_cast<std::size_t>(run)) : folder_.path() / "panels" / fmt::format("difference-{}", k + 1);
    }

    /// Draws the difference of two panels from their raw frames. The colour range covers 99 % of the fluid in each of at most 24 frames,
    /// evenly spaced. If the raw frames were removed, existing images are kept. @throws InputError if a frame is missing or damaged
    void draw_difference(std::size_t k, int frames) const {
        const PanelCell& cell = cells_[k];
        const fs::path one = panel(static_cast<std::size_t>(cell.between[0])), other = panel(static_cast<std::size_t>(cell.between[1]));
        const fs::path folder = pictures_of(k);
        if (!fs::exists(frame_file(one, frames)) && fs::exists(picture_file(folder, frames))) return;
        const auto pair_of = [&](int number) {
            return std::pair{read_frame(frame_file(one, number)), read_frame(frame_file(other, number))};
        };
        const SceneFile& file = scenes_[static_cast<std::size_t>(cell.between[0])];
        constexpr int looked_at = 24;  // frames
        float most = 0;
        for (int n = 0; n < std::min(frames, looked_at); ++n) {
            const auto [a, b] = pair_of(frames <= looked_at ? n + 1 : 1 + n * (frames - 1) / (looked_at - 1));
            most = std::max(most, usual_difference(a, b, file.look));
        }
        const float high = most > 0 ? static_cast<float>(round_number_above(most)) : 1;
        LookOptions look = file.look;
        look.title = scene_.panels[k].label.empty() ? "difference" : scene_.panels[k].label;
        const std::optional<ShownBox> box = file.camera.box();
        fs::create_directories(folder / "frames");
        for (int number = 1; number <= frames; ++number) {
            const auto [a, b] = pair_of(number);
            write_png(picture_file(folder, number), draw_difference_plate(a, b, look, {-high, high}, file.scene.output.size, box));
        }
    }

    /// Chart with a curve of output.chart for each run; empty without output.chart.
    PanelChart chart() const {
        const std::string& of = scene_.output.chart;
        const std::size_t dot = of.rfind('.');
        PanelChart chart;
        chart.title = of.substr(dot + 1), chart.width = scene_.output.size[0], chart.height = chart_height(scene_);
        chart.text = panel_text(request_.file) / 0.73;  // a font's size over the height of its capitals
        std::replace(chart.title.begin(), chart.title.end(), '_', ' ');
        chart.dark = scenes_[0].look.background == "dark";
        for (std::size_t k = 0; !of.empty() && k < scenes_.size(); ++k) {
            const CsvTable table = read_csv(panel(k) / "probes" / (of.substr(0, dot) + ".csv"));
            Curve curve;
            curve.label = name_of(k);
            for (const std::vector<double>& row : table.rows)
                curve.x.push_back(row[table.index("time")]), curve.y.push_back(row[table.index(of.substr(dot + 1))]);
            chart.curve.push_back(std::move(curve));
        }
        return chart;
    }

    /// Combines the panels' images of each frame, and encodes the video.
    void film(int frames) const {
        fs::create_directories(folder_.path() / "frames");
        const int width = scene_.output.size[0], height = scene_.output.size[1];
        const std::array<int, 2>& panel_size = scenes_[0].scene.output.size;
        for (std::size_t k = 0; k < cells_.size(); ++k)
            if (cells_[k].run < 0) draw_difference(k, frames);
        const PanelChart chart = this->chart();
        std::optional<VideoEncoder> encoder;
        if (scene_.output.video) encoder.emplace(video(), width, height, VideoOptions{scene_.time.fps, 18});
        for (int frame = 1; frame <= frames; ++frame) {
            std::vector<Image> images;
            for (std::size_t k = 0; k < cells_.size(); ++k)
                images.push_back(read_picture(pictures_of(k), frame, panel_size[0], panel_size[1]));
            Image picture = side_by_side(images, panel_columns(scene_), panel_gap, width, height - chart.height);
            if (chart.height > 0) picture = one_above_other(picture, chart.at(frame_time(scene_, frame)));
            write_png(picture_file(folder_.path(), frame), picture);
            if (encoder) encoder->add(picture);
        }
        if (encoder) encoder->finish();
        write_contact_sheet(folder_.path(), frames);
        for (std::size_t k = 0; has_differences() && !scene_.exported("raw") && k < scenes_.size(); ++k) fs::remove_all(panel(k) / "raw");
    }

    void write_report(const std::string& status, const std::string& message) const {
        Json panels = Json::array();
        double wall = 0, cpu = 0;
        for (std::size_t k = 0; k < scenes_.size(); ++k) {
            const nlohmann::json run = report_of(panel(k));
            wall += run.value("wall_seconds", 0.0), cpu += run.value("cpu_seconds", 0.0);
            panels.push_back({{"label", scene_.panels[panel_of(k)].label},
                              {"folder", "panels/" + std::to_string(k + 1)},
                              {"status", run.value("status", "waiting")},
                              {"frames", run.value("frames", 0)}});
        }
        const Json report{{"whorl", WHORL_VERSION}, {"build", build_id()}, {"scene", scene_.name},     {"status", status},
                          {"message", message},     {"panels", panels},    {"frames", least_frames()}, {"frames_planned", frames_wanted()},
                          {"wall_seconds", wall},   {"cpu_seconds", cpu}};
        write_text(folder_.path() / "run.json", json_text(report, 2) + "\n");
    }

    const RunRequest& request_;
    const Scene& scene_;
    std::vector<SceneFile> scenes_;  ///< of the runs
    std::vector<PanelCell> cells_;
    RunFolder folder_;
};

}  // namespace

int run_panels(const RunRequest& request, bool resumed) {
    if (!resumed) RunFolder::check_fresh(request.folder, request.overwrite);  // also checked here, before the coarse runs
    if (wants_pictures(request) && request.file.scene.output.video) check_video(request.file.scene);
    return PanelFilm(request, resumed).make();
}

}  // namespace whorl

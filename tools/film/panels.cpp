#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/version.h"
#include "engine/core/whole_file.h"
#include "engine/io/csv.h"
#include "engine/io/frame.h"
#include "engine/scene/scene.h"
#include "render/flow/plate.h"
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

/// Whether they are to be drawn now.
bool wants_pictures(const RunRequest& request) { return request.file.scene.output.images && !request.no_draw; }

fs::path panel_folder(const fs::path& run_folder, std::size_t run) { return run_folder / "panels" / std::to_string(run + 1); }

class PanelFilm {
public:
    PanelFilm(const RunRequest& request, PanelRuns how)
        : request_(request), scene_(request.file.scene), scenes_(panel_scenes(request.file, choice())), cells_(panel_cells(request.file)),
          folder_(how == PanelRuns::fresh ? RunFolder::fresh(request.folder, request.earlier) : RunFolder::existing(request.folder)) {
        if (how == PanelRuns::resumed) {
            for (std::size_t k = 0; k < scenes_.size(); ++k) check_end(folder_.path(), scene_, frames_of(k), frames_wanted());
            restarts_ = lacks_frames_of_differences();
            check_resumed();
            check_made_pictures();
        }
        write_text(folder_.path() / "scene.resolved.toml", resolved_toml(with_choices_of(request.file, scenes_)));
        if (!folder_.note().empty()) tell_note(folder_.note(), request.json);
    }

    int go() {
        write_report("running", "");
        if (const std::optional<std::size_t> stopped = run_all()) {
            const std::string go_on = "whorl resume " + folder_.path().string() + (request_.no_draw ? " --no-draw" : "");
            write_report("interrupted", "continue with: " + go_on);
            std::fprintf(stderr, "whorl: panel %zu of %zu was interrupted; continue all of them with:  %s\n", *stopped + 1, scenes_.size(),
                         go_on.c_str());
            return exit_interrupted;
        }
        const int frames = least_frames();
        const bool filmed = wants_pictures(request_) && frames > 0;
        if (filmed) film(1, frames, true);
        const std::string status = failed_ ? "diverged" : "done";
        write_report(status, failed_ ? "panel " + name_of(*failed_) + " diverged" : "");
        if (!request_.quiet && !request_.json)
            std::fprintf(stderr, "%s of %zu panels: %s\n", counted(frames, "frame").c_str(), scenes_.size(),
                         (filmed && scene_.output.video ? video() : folder_.path()).c_str());
        if (!request_.quiet && !request_.json && request_.no_draw && scene_.output.images && frames > 0)
            std::fprintf(stderr, "draw each panel (whorl draw %s), then put them together: whorl resume %s\n",
                         panel_folder(folder_.path(), 0).c_str(), folder_.path().c_str());
        return failed_ ? exit_failed : exit_done;
    }

private:
    Choose choice() const {
        if (!scene_.output.images) return {};
        return [watch = watch_coarse_run(request_.quiet || request_.json)](const SceneFile& run, const Simulation& start) {
            return with_choices(run, start, watch);
        };
    }

    fs::path video() const { return folder_.path() / (scene_.name + ".mp4"); }
    int frames_of(std::size_t k) const { return report_of(panel_folder(folder_.path(), k)).value("frames", 0); }
    int frames_wanted() const { return request_.frames.value_or(frame_count(scene_)); }

    /// Whether the panel is complete.
    bool is_done(std::size_t k) const {
        const nlohmann::json run = report_of(panel_folder(folder_.path(), k));
        return run.value("status", "") == "done" && run.value("frames", 0) >= frames_wanted();
    }

    bool has_raw(std::size_t k) const { return fs::exists(frame_file(panel_folder(folder_.path(), k), 1)); }

    /// Whether a longer film needs missing frames: the colours of a difference depend on all frames of both runs.
    bool lacks_frames_of_differences() const {
        if (!has_differences() || !scene_.output.images) return false;
        for (std::size_t k = 0; k < scenes_.size(); ++k)
            if (report_of(panel_folder(folder_.path(), k)).value("status", "") == "done" && !is_done(k) && !has_raw(k)) return true;
        return false;
    }

    enum class Next { nothing, begins, goes_on };
    /// Next action for a panel.
    Next next_of(std::size_t k) const {
        const fs::path folder = panel_folder(folder_.path(), k);
        const std::string status = report_of(folder).value("status", "");
        if (restarts_ && !has_raw(k)) return Next::begins;
        if (is_done(k) || status == "diverged") return Next::nothing;
        // If all checkpoints are damaged, resuming is refused: the panel is left untouched for repair.
        return has_checkpoint(folder) ? Next::goes_on : Next::begins;
    }

    /// @throws InputError with the reason that a panel cannot continue
    void check_resumed() const {
        for (std::size_t k = 0; k < scenes_.size(); ++k)
            if (next_of(k) == Next::goes_on) {
                RunRequest panel = request_of(k);
                resume_from_newest(panel);
            }
    }

    /// Images may be left to draw, and a panel may have been drawn again in another size. @throws InputError
    void check_made_pictures() const {
        for (std::size_t k = 0; k < scenes_.size() && wants_pictures(request_); ++k) {
            const std::array<int, 2>& size = scenes_[k].scene.output.size;
            if (frames_of(k) == 0 || next_of(k) == Next::begins) continue;
            const fs::path folder = panel_folder(folder_.path(), k);
            check_pictures(folder, frames_of(k));
            read_picture(folder, 1, size[0], size[1]);
        }
    }

    /// Name of the run's panel.
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
        RunRequest panel;
        panel.file = scenes_[k];
        panel.folder = panel_folder(folder_.path(), k);
        panel.frames = request_.frames;
        panel.no_draw = request_.no_draw, panel.force = request_.force;
        panel.quiet = request_.quiet, panel.json = request_.json;
        return panel;
    }

    /// Makes panel k's request one to begin or to resume. @return whether there is anything to do
    bool prepare(std::size_t k, RunRequest& panel) {
        const Next next = next_of(k);
        if (next == Next::nothing) {
            if (!is_done(k)) failed_ = k;
            return false;
        }
        const bool again = restarts_ && next == Next::begins;
        if (!request_.quiet && !request_.json)
            std::fprintf(stderr, "panel %zu of %zu: %s%s\n", k + 1, scenes_.size(), name_of(k).c_str(),
                         again ? ", from the start: the difference needs all its frames, which --export raw would have kept" : "");
        panel.earlier = RunFolder::Earlier::replaced;
        if (next == Next::goes_on) resume_from_newest(panel);
        return true;
    }

    /// Simulates the frames of all panels in turn, and films those that all panels have. @return the first panel that was interrupted
    std::optional<std::size_t> run_all() {
        const InterruptGuard guard;
        const std::size_t count = scenes_.size();
        std::vector<RunRequest> requests;
        for (std::size_t k = 0; k < count; ++k) requests.push_back(request_of(k));
        std::vector<std::unique_ptr<FramedRun>> runs(count);
        for (std::size_t k = 0; k < count; ++k)
            if (prepare(k, requests[k])) runs[k] = begin_run(requests[k]);
        std::optional<std::size_t> stopped;
        for (int frame = 0; std::any_of(runs.begin(), runs.end(), [](const auto& run) { return run != nullptr; }); ++frame) {
            for (std::size_t k = 0; k < count; ++k) {
                if (!runs[k] || runs[k]->frame() > frame || runs[k]->next()) continue;
                const int code = runs[k]->finish();
                runs[k].reset();
                if (code == exit_failed) failed_ = k;
                if (code == exit_interrupted && !stopped) stopped = k;
            }
            if (wants_pictures(request_)) film_ready(runs);
        }
        return stopped;
    }

    bool goes_by_whole_film() const { return has_differences() || !scene_.output.chart.empty(); }

    /// Frames whose pictures all panels have; those that are made again at the end at intervals of 2 s.
    void film_ready(const std::vector<std::unique_ptr<FramedRun>>& runs) {
        int ready = std::numeric_limits<int>::max();
        for (std::size_t k = 0; k < runs.size(); ++k) ready = std::min(ready, runs[k] ? runs[k]->frames_written() : frames_of(k));
        if (ready <= filmed_ || (goes_by_whole_film() && filmed_ > 0 && wall_seconds() - filmed_at_ < 2)) return;
        film(filmed_ + 1, ready, false);
        filmed_ = ready, filmed_at_ = wall_seconds();
    }

    /// Frames that every panel has.
    int least_frames() const {
        int least = 1 << 30;
        for (std::size_t k = 0; k < scenes_.size(); ++k) least = std::min(least, frames_of(k));
        return least;
    }

    /// Folder of a panel's images; those of a difference are drawn first.
    fs::path pictures_of(std::size_t panel, int first, int last) const {
        const PanelCell& cell = cells_[panel];
        if (cell.run >= 0) return panel_folder(folder_.path(), static_cast<std::size_t>(cell.run));
        const fs::path folder = folder_.path() / "panels" / ("difference-" + std::to_string(panel + 1));
        const auto run_folder = [&](int n) { return panel_folder(folder_.path(), static_cast<std::size_t>(cell.between[n])); };
        const std::string& label = scene_.panels[panel].label;
        draw_differences(scenes_[cell.between[0]], label.empty() ? "difference" : label, run_folder(0), run_folder(1), folder, first, last);
        return folder;
    }

    /// Chart of the curves up to now. Without a chart: empty.
    PanelChart chart() const {
        const std::string& of = scene_.output.chart;
        const std::size_t dot = of.rfind('.');
        PanelChart chart;
        chart.title = of.substr(dot + 1), chart.width = scene_.output.size[0], chart.height = chart_height(scene_);
        std::replace(chart.title.begin(), chart.title.end(), '_', ' ');
        chart.dark = scenes_[0].look.background == "dark";
        for (std::size_t k = 0; !of.empty() && k < scenes_.size(); ++k) {
            const CsvTable table = read_csv(panel_folder(folder_.path(), k) / "probes" / (of.substr(0, dot) + ".csv"));
            Curve curve;
            curve.label = name_of(k);
            for (const std::vector<double>& row : table.rows)
                curve.x.push_back(row[table.index("time")]), curve.y.push_back(row[table.index(of.substr(dot + 1))]);
            chart.curve.push_back(std::move(curve));
        }
        return chart;
    }

    /// @param whole all frames, for the video; existing ones are kept if nothing in them depends on the whole film
    void film(int first, int last, bool whole) const {
        fs::create_directories(folder_.path() / "frames");
        const int width = scene_.output.size[0], height = scene_.output.size[1];
        const std::array<int, 2>& panel_size = scenes_[0].scene.output.size;
        std::vector<fs::path> folders;
        for (std::size_t k = 0; k < cells_.size(); ++k) folders.push_back(pictures_of(k, first, last));
        const PanelChart chart = this->chart();
        std::optional<VideoEncoder> encoder;
        if (whole && scene_.output.video) encoder.emplace(video(), width, height, VideoOptions{scene_.time.fps, 18});
        for (int frame = first; frame <= last; ++frame) {
            if (frame <= filmed_ && !goes_by_whole_film()) {
                if (encoder) encoder->add(read_picture(folder_.path(), frame, width, height));
                continue;
            }
            std::vector<Image> images;
            for (const fs::path& folder : folders) images.push_back(read_picture(folder, frame, panel_size[0], panel_size[1]));
            Image picture = side_by_side(images, panel_columns(scene_), panel_gap, width, height - chart.height);
            if (chart.height > 0) picture = one_above_other(picture, chart.at(frame_time(scene_, frame)));
            write_png(picture_file(folder_.path(), frame), picture);
            if (encoder) encoder->add(picture);
        }
        if (!whole) return;
        if (encoder) encoder->finish();
        write_contact_sheet(folder_.path(), last);
        for (std::size_t k = 0; has_differences() && !scene_.exported("raw") && k < scenes_.size(); ++k)
            fs::remove_all(panel_folder(folder_.path(), k) / "raw");
    }

    void write_report(const std::string& status, const std::string& message) const {
        Json panels = Json::array();
        double wall = 0, cpu = 0;
        for (std::size_t k = 0; k < scenes_.size(); ++k) {
            const nlohmann::json run = report_of(panel_folder(folder_.path(), k));
            // They run side by side, and each counts the process.
            wall = std::max(wall, run.value("wall_seconds", 0.0)), cpu = std::max(cpu, run.value("cpu_seconds", 0.0));
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
    bool restarts_ = false;  ///< restart panels whose frames a difference lacks
    std::optional<std::size_t> failed_;
    int filmed_ = 0;        ///< frames whose panels are joined
    double filmed_at_ = 0;  ///< s, wall
};

}  // namespace

int run_panels(const RunRequest& request, PanelRuns how) {
    if (how == PanelRuns::fresh) RunFolder::check_fresh(request.folder);  // not only after the coarse runs
    if (wants_pictures(request) && request.file.scene.output.video)
        check_video_rate(request.file.scene), check_encoder(without_video(how == PanelRuns::resumed));
    return PanelFilm(request, how).go();
}

void draw_differences(const SceneFile& file, const std::string& title, const fs::path& one, const fs::path& other, const fs::path& folder,
                      int first, int last) {
    if (!fs::exists(frame_file(one, last)) && fs::exists(picture_file(folder, last))) return;
    const auto pair_of = [&](int number) { return std::pair{read_frame(frame_file(one, number)), read_frame(frame_file(other, number))}; };
    constexpr int looked_at = 24;  // frames
    float most = 0;
    for (int n = 0; n < std::min(last, looked_at); ++n) {
        const auto [a, b] = pair_of(last <= looked_at ? n + 1 : 1 + n * (last - 1) / (looked_at - 1));
        most = std::max(most, usual_difference(a, b, file.look));
    }
    const float high = most > 0 ? static_cast<float>(round_number_above(most)) : 1;
    LookOptions look = file.look;
    look.title = title;
    fs::create_directories(folder / "frames");
    for (int number = first; number <= last; ++number) {
        const auto [a, b] = pair_of(number);
        const auto& size = file.scene.output.size;
        write_png(picture_file(folder, number), draw_difference_plate(a, b, look, {-high, high}, size[0], size[1]));
    }
}

}  // namespace whorl

#include "tools/film/run.h"

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/io/snapshot.h"
#include "engine/probes/comparison.h"
#include "engine/scene/scene.h"
#include "render/look/field_values.h"
#include "render/video/encoder.h"
#include "tools/cost/coarse_run.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/film.h"
#include "tools/film/frame_loop.h"
#include "tools/film/progress.h"
#include "tools/film/report.h"
#include "tools/film/tables.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

/// Fields that a frame needs in addition to positions and velocities.
std::vector<std::string> snapshot_fields(const SceneFile& file, const World& world) {
    std::vector<std::string> fields = shown_fields(file.look);
    for (const std::string& name : exported_fields(file.scene, world.fluid))
        if (std::find(fields.begin(), fields.end(), name) == fields.end()) fields.push_back(name);
    return fields;
}

class Run : public FrameLoopHost {
public:
    Run(const RunRequest& request, const Plan& plan, std::string encoder)
        : request_(request), scene_(request.file.scene), last_(request.frames.value_or(frame_count(scene_))), simulation_(scene_, plan),
          file_(chosen()), replay_(file_),
          folder_(request.from ? RunFolder::existing(request.folder) : RunFolder::fresh(request.folder, request.overwrite)),
          scene_text_(resolved_toml(file_)) {
        make_folders();
        report_.encoder = std::move(encoder);
        report_.draws = film_options().output.images;
        report_.frames_planned = last_;
        if (request.from) resume();
        frame_ = first_ - 1;
        loop_.emplace(*this, simulation_, replay_.now(), last_, TheorySearch::wait);
        tables_.emplace(folder_.path(), simulation_, loop_->probes(), scene_.budget.any(), request.from ? &*request.from : nullptr);
        loop_->scene_changed(replay_.now());
        greet(plan);
        film_.emplace(film_options());
        write_report("running", "");
    }

    /// Makes the frames. If it throws, existing files are kept.
    int make() try {
        while (frame_ < last_ && simulate()) {}
        return complete();
    } catch (const std::exception& error) {
        log_->error("{}", error.what());
        try {
            save_newest();
            write_report("failed", error.what());
        } catch (const std::exception&) {  // the disk is probably full: existing files are kept
        }
        std::error_code none;
        if (const std::string folder = folder_.path().string(); !fs::exists(folder, none) && !none)
            throw EnvironmentError("the folder " + folder + " was removed or renamed while the run was at work", "",
                                   "if it was moved, put it back and continue with: whorl resume " + folder);
        throw;
    }

private:
    int frames_written() const { return std::max(first_ - 1, film_->frames_written()); }

    /// The scene with its choices for the whole run. They are stored in scene.resolved.toml and in every checkpoint, so a resumed run keeps
    /// them.
    SceneFile chosen() const {
        check_probes(simulation_);
        return with_choices(request_.file, simulation_, watch_coarse_run(request_.quiet || request_.json));
    }

    FilmOptions film_options() const {
        FilmOptions options{request_.folder, scene_.name, scene_.output, scene_.time, first_ - 1};
        if (request_.no_draw) options.output.images = false;
        return options;
    }

    void make_folders() {
        // The file that marks a run folder is written first: if the disk is full, the folder stays empty, and the next run can use it.
        write_text(folder_.path() / "scene.resolved.toml", scene_text_);
        std::vector<std::string> names;
        if (scene_.output.images) names.emplace_back("frames");
        if (!scene_.probes.empty()) names.emplace_back("probes");
        for (const std::string& name : names) fs::create_directories(folder_.path() / name);
        spdlog::drop("run");
        log_ = spdlog::basic_logger_mt("run", (folder_.path() / "log.txt").string());
        log_->flush_on(spdlog::level::info);
    }

    void resume() {
        const Checkpoint& from = *request_.from;
        std::istringstream state(from.simulation);
        simulation_.load(state);
        replay_.apply_until(simulation_.time(),
                            [&](const Scene& s, const Plan& p, double time) { simulation_.changed_before(s, p, time); });
        first_ = from.frame + 1;
        report_.incidents.add_earlier(report_of(folder_.path()).value("first_troubles", nlohmann::json::array()));
        times_.add_earlier(from);
    }

    /// Prints the run's plan on the terminal and in its log.
    void greet(const Plan& plan) {
        log_->info("whorl {}, {}: frames {} to {}", build_id(), scene_.name, first_, last_);
        for (const Choice& c : plan.choices) log_->info("{} = {}{}: {}", c.key, c.value, c.automatic ? " (auto)" : "", c.reason);
        for (const std::string& warning : plan.warnings) log_->warn("{}", warning);
        progress_.emplace(first_, last_, request_.quiet, request_.json);
        for (const std::string& warning : plan.warnings) progress_->say("warning: " + warning);
        std::vector<double> foreseen = foreseen_frames(plan);
        if (foreseen.empty()) return;
        report_.predicted_wall = std::accumulate(foreseen.begin(), foreseen.begin() + last_, 0.0);
        const double before = std::accumulate(foreseen.begin(), foreseen.begin() + first_ - 1, 0.0);
        progress_->say(fmt::format("about {} expected", duration(report_.predicted_wall - before)));
        progress_->foresee(std::move(foreseen));
    }

    /// Predicted wall time of each frame [s]; empty if this scene has no coarse run.
    std::vector<double> foreseen_frames(const Plan& plan) const {
        SceneFile file = request_.file;
        const auto costs = find_coarse_run(file);
        if (!costs) return {};
        // A resumed run looks up the coarse run by this scene.
        if (!request_.from) keep_coarse_run(read_resolved(scene_text_, "scene.resolved.toml"), *costs);
        if (request_.no_draw) file.scene.output.images = false;
        std::vector<double> frames = estimate(file, plan, simulation_, *costs).frames_seconds;
        frames.resize(std::max(frames.size(), static_cast<std::size_t>(last_)), frames.back());
        return frames;
    }

    bool stop_wanted() override { return interrupt_.interrupted(); }

    void after_step(const StepReport& report, double began) override {
        const long step = simulation_.totals().steps + (report.diverged ? 1 : 0);
        if (const std::string news = report_.incidents.add(report, scene_, began, step); !news.empty()) progress_->note(news);
        if (report.diverged) return;
        progress_->step(simulation_, frame_);
        if (replay_.apply_until(simulation_.time(), [&](const Scene& s, const Plan& p, double when) { simulation_.change(s, p, when); }))
            loop_->scene_changed(replay_.now());
    }

    void set_pictures(const SceneFile& file) override {
        snapshots_.emplace(simulation_, snapshot_fields(file, simulation_.world()));
        pictures_ = std::make_shared<const PictureOptions>(PictureOptions{file.surface, file.camera, file.look});
    }

    /// Simulates the next frame. @return false if its time was not reached
    bool simulate() {
        ++frame_;
        if (!times_.simulate([&] { return loop_->step_to(frame_time(scene_, frame_)); })) return false;
        add_frame();
        return true;
    }

    /// Adds the frame's rows to the tables and passes the frame to the threads that draw and write.
    void add_frame() {
        // The volume is measured once per simulated second: in every frame it would take 15 % of a thread's time.
        const int frames_per_volume = std::max(1, static_cast<int>(std::lround(1 / scene_.time.frame_interval())));
        FrameSummary summary = loop_->measure_frame();
        if ((frame_ - 1) % frames_per_volume == 0) summary.measures.volume = coupled_volume(simulation_.world());
        tables_->add_frame(frame_, summary, times_.wall(), times_.cpu());
        const double now = wall_seconds(), seconds = now - std::exchange(frame_done_at_, now);
        if (scene_.budget.any() && summary.steps > 0)
            if (const std::string row = loop_->hold_to_budget(summary, frame_, seconds, times_.wall()); !row.empty())
                tables_->add_budget(row);
        const bool due = frame_ == last_ || wall_seconds() - saved_at_ >= scene_.output.checkpoint_every;
        film_->add(snapshots_->take(simulation_, frame_), pictures_, state(), due);
        if (due) {
            saved_at_ = wall_seconds();
            write_report("running", "");
        }
        progress_->frame_done(simulation_, frame_, summary.iterations);
        if (frame_ < last_) loop_->apply_governor();
    }

    std::shared_ptr<Checkpoint> state() const {
        auto state = std::make_shared<Checkpoint>();
        state->build = build_id();
        state->scene = scene_text_;
        state->inputs = inputs_;
        state->frame = frame_;
        state->frames = last_;
        state->wall = times_.wall(), state->cpu = times_.cpu(), state->stages = stages(), state->resumed = times_.resumed();
        tables_->save(*state);
        std::ostringstream particles;
        simulation_.save(particles);
        state->simulation = std::move(particles).str();
        state->simulation.shrink_to_fit();  // the state is kept until the image of its frame is on disk
        return state;
    }

    StageTimes stages() const { return times_.stages(simulation_.times(), film_->times()); }

    int complete() {
        const std::optional<Divergence>& diverged = simulation_.world().report.diverged;
        const std::string folder = folder_.path().string();
        if (diverged) {
            film_->finish(true);
            const Vec3d& x = diverged->place;
            const int made = film_->frames_written();
            return conclude(
                "diverged",
                fmt::format("the run diverged at {:.6g} s in stage \"{}\"{}, field \"{}\", at ({:.4g}, {:.4g}, {:.4g}) m: {}; the "
                            "{} before it {} in {}",
                            diverged->time, diverged->stage, diverged->stage == "force" ? " (fluid.force)" : "", diverged->field, x.x(),
                            x.y(), x.z(), diverged->what, counted(made, "frame"), made == 1 ? "is" : "are", folder));
        }
        const bool complete = simulation_.time() >= frame_time(scene_, last_);
        if (!complete) progress_->say("interrupted: completing the frames in progress");
        film_->finish(complete);
        if (complete) return conclude("done", "");
        save_newest();
        if (frames_written() == 0) return conclude("interrupted", "interrupted before the first frame");
        return conclude("interrupted", fmt::format("interrupted after frame {} of {}; continue with: whorl resume {}{}", frames_written(),
                                                   last_, folder, request_.no_draw ? " --no-draw" : ""));
    }

    int conclude(const std::string& status, const std::string& message) {
        if (report_.draws) write_contact_sheet(folder_.path(), frames_written());
        tables_->draw_plots();
        write_report(status, message);
        const double wall = times_.wall();
        log_->info("{} after {} frames, {} steps, {:.1f} s{}{}", status, frames_written(), simulation_.totals().steps, wall,
                   message.empty() ? "" : ": ", message);
        if (status == "done") say_done(wall);
        if (request_.json) print_result(status, message, wall);
        progress_.reset();
        if (status == "done") return exit_done;
        std::fprintf(stderr, "whorl: %s\n", message.c_str());
        return status == "interrupted" ? exit_interrupted : exit_failed;
    }

    void say_done(double wall) {
        if (const RunTotals& totals = simulation_.totals(); totals.unconverged_solves > 0)
            progress_->note(fmt::format("{} solves of {} steps ended before their tolerance (run.json: first_troubles)",
                                        totals.unconverged_solves, totals.steps));
        const fs::path video = film_options().video();
        const std::string expected = report_.predicted_wall > 0 ? fmt::format(" ({} expected)", duration(report_.predicted_wall)) : "";
        progress_->say(fmt::format("{}, done in {}{}: {}", counted(frames_written(), "frame"), duration(wall), expected,
                                   (video.empty() ? folder_.path() : video).string()));
    }

    void print_result(const std::string& status, const std::string& message, double wall) const {
        const nlohmann::ordered_json result{{"event", "result"},
                                            {"status", status},
                                            {"message", message},
                                            {"folder", folder_.path().string()},
                                            {"frames", frames_written()},
                                            {"time", simulation_.time()},
                                            {"particles", simulation_.world().fluid.size()},
                                            {"wall_seconds", wall}};
        std::printf("%s\n", json_text(result).c_str());
    }

    void write_report(const std::string& status, const std::string& message) {
        report_.status = status, report_.message = message;
        report_.frames = frames_written();
        report_.wall = times_.wall(), report_.cpu = times_.cpu(), report_.resumed = times_.resumed();
        report_.gl_device = film_->device();
        report_.stages = stages();
        write_text(folder_.path() / "run.json", json_text(run_json(simulation_, report_), 2) + "\n");
    }

    /// Saves the state of the last frame whose row and image are on disk.
    void save_newest() {
        if (const auto state = film_->newest_state()) write_checkpoint(folder_.path(), *state);
    }

    const RunRequest& request_;
    const Scene& scene_;
    RunTimes times_;
    std::map<std::string, std::uint64_t> inputs_ = input_checksums(request_.file);
    int first_ = 1, last_ = 1;  ///< frames that this part of the run makes
    int frame_ = 0;             ///< number of the frame in progress
    Simulation simulation_;     ///< may throw InputError when it places fluid and solids, so it precedes folder_
    SceneFile file_;            ///< the requested scene with the choices made at the start
    Replay replay_;             ///< changes during the run
    RunFolder folder_;
    std::shared_ptr<spdlog::logger> log_;
    std::string scene_text_;
    std::optional<FrameLoop> loop_;
    std::optional<RunTables> tables_;
    std::optional<Snapshots> snapshots_;
    std::shared_ptr<const PictureOptions> pictures_;  ///< options of the next images
    double frame_done_at_ = wall_seconds(), saved_at_ = wall_seconds();
    RunReport report_;
    InterruptGuard interrupt_;
    std::optional<Progress> progress_;
    std::optional<Film> film_;
};

}  // namespace

std::string check_video(const Scene& scene, bool here) {
    if (scene.time.fps < least_video_fps)
        throw InputError(scene.place("time.fps"), fmt::format("time.fps = {:g}: too few frames per second for a video", scene.time.fps),
                         "set output.video = false", fmt::format("allowed: at least {:g}", least_video_fps));
    return here ? check_encoder("or run with --no-video") : "";
}

int run_scene(const RunRequest& request) {
    const Plan plan = make_plan(request.file);
    if (!request.from) RunFolder::check_fresh(request.folder, request.overwrite);  // also checked here, before the coarse run
    const OutputKeys& output = request.file.scene.output;
    return Run(request, plan, output.images && output.video && !request.no_draw ? check_video(request.file.scene) : "").make();
}

}  // namespace whorl

#include "tools/film/run.h"

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

#include "engine/core/errors.h"
#include "engine/core/whole_file.h"
#include "engine/io/snapshot.h"
#include "engine/probes/comparison.h"
#include "engine/scene/scene.h"
#include "render/look/field_values.h"
#include "render/video/encoder.h"
#include "tools/cost/estimate.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/film.h"
#include "tools/film/frame_loop.h"
#include "tools/film/progress.h"
#include "tools/film/report.h"
#include "tools/film/run_folder.h"
#include "tools/film/tables.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"
#include "tools/scene_file/camera_warnings.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

FilmOptions film_options(const RunRequest& request, const SceneFile& file, int frames_before) {
    const Scene& scene = file.scene;
    FilmOptions options;
    options.folder = request.folder;
    options.images = scene.output.images && !request.no_draw;
    if (options.images && scene.output.video) options.video = request.folder / (scene.name + ".mp4");
    options.name = scene.name;
    options.exports = scene.output.exports;
    options.format = scene.output.format;
    options.width = scene.output.size[0];
    options.height = scene.output.size[1];
    options.fps = scene.time.fps;
    options.interval = scene.time.frame_interval();
    options.frames_before = frames_before;
    return options;
}

/// Fields that a frame needs in addition to positions and velocities.
std::vector<std::string> snapshot_fields(const SceneFile& file, const World& world) {
    std::vector<std::string> fields = shown_fields(file.look);
    for (const std::string& name : exported_fields(file.scene, world.fluid))
        if (std::find(fields.begin(), fields.end(), name) == fields.end()) fields.push_back(name);
    return fields;
}

class Run : public FrameLoopHost, public FramedRun {
public:
    Run(const RunRequest& request, const Plan& plan, std::string encoder);
    bool next() override;
    int frame() const override { return frame_; }
    int frames_written() const override { return std::max(first_ - 1, film_->frames_written()); }
    int finish() override;

private:
    SceneFile chosen() const;
    void make_folders();
    void resume();
    void greet(const Plan& plan);
    std::optional<Estimate> foreseen(SceneFile file, const Plan& plan) const;
    std::vector<double> foreseen_frames(const Plan& plan) const;

    bool stop_wanted() override { return interrupt_.interrupted(); }
    void after_step(const StepReport& report, double began) override;
    void add_budget(const BudgetRow& row) override { tables_->add_budget(row); }
    void set_pictures(const SceneFile& file) override;

    template <class Work>
    auto keeping(const Work& work);
    bool simulate();
    void add_frame();
    std::shared_ptr<Checkpoint> state() const;
    StageTimes stages() const { return times_.stages(simulation_.times(), film_->times()); }

    int complete();
    int conclude(const std::string& status, const std::string& message);
    void say_done(double wall);
    void print_result(const std::string& status, const std::string& message, double wall) const;
    void write_report(const std::string& status, const std::string& message);
    void save_newest();

    const RunRequest& request_;
    const Scene& scene_;
    RunTimes times_;
    std::map<std::string, std::uint64_t> inputs_ = input_checksums(request_.file);
    int first_ = 1, last_ = 1;  ///< frames that this part of the run makes
    int frame_ = 0;             ///< on its way
    Simulation simulation_;     ///< places fluid and solids: may throw InputError, so the folder comes after it
    SceneFile file_;            ///< the request's, with the choices of the start
    Replay replay_;             ///< changes during the run
    RunFolder folder_;
    std::shared_ptr<spdlog::logger> log_;
    std::string scene_text_, encoder_;
    std::optional<FrameLoop> loop_;
    std::optional<RunTables> tables_;
    std::optional<Snapshots> snapshots_;
    std::shared_ptr<const PictureOptions> pictures_;  ///< how they are made now
    Incidents incidents_;
    double frame_done_at_ = wall_seconds(), saved_at_ = wall_seconds();
    std::vector<double> foreseen_;  ///< s, of each frame, where costs were measured before
    double predicted_ = 0;          ///< s, wall time of the whole run where costs were measured before (whorl plan); else 0
    InterruptGuard interrupt_;
    std::optional<Progress> progress_;
    std::optional<Film> film_;
};

Run::Run(const RunRequest& request, const Plan& plan, std::string encoder)
    : request_(request), scene_(request.file.scene), last_(request.frames.value_or(frame_count(scene_))), simulation_(scene_, plan),
      file_(chosen()), replay_(file_),
      folder_(request.from ? RunFolder::existing(request.folder) : RunFolder::fresh(request.folder, request.earlier)),
      scene_text_(resolved_toml(file_)), encoder_(std::move(encoder)) {
    make_folders();
    foreseen_ = foreseen_frames(plan);
    if (request.from) resume();
    frame_ = first_ - 1;
    loop_.emplace(*this, simulation_, replay_.now(), last_, TheorySearch::wait);
    tables_.emplace(folder_.path(), simulation_, loop_->probes(), scene_.budget.any(), request.from ? &*request.from : nullptr);
    if (request.from) loop_->governor().set(tables_->last_given_up());
    loop_->scene_changed(replay_.now());
    greet(plan);
    film_.emplace(film_options(request, file_, first_ - 1));
    write_report("running", "");
}

/// Prints the run's plan on the terminal and in its log.
void Run::greet(const Plan& plan) {
    log_->info("whorl {}, {}: frames {} to {}", build_id(), scene_.name, first_, last_);
    for (const Choice& c : plan.choices) log_->info("{} = {}{}: {}", c.key, c.value, c.automatic ? " (auto)" : "", c.reason);
    for (const std::string& warning : plan.warnings) log_->warn("{}", warning);
    progress_.emplace(first_, last_, request_.quiet, request_.json);
    if (!folder_.note().empty()) progress_->note(folder_.note());
    for (const std::string& warning : plan.warnings) progress_->say("warning: " + warning);
    if (foreseen_.empty()) return;
    predicted_ = std::accumulate(foreseen_.begin(), foreseen_.begin() + last_, 0.0);
    const double before = std::accumulate(foreseen_.begin(), foreseen_.begin() + first_ - 1, 0.0);
    progress_->foresee(foreseen_);
    progress_->say(fmt::format("about {} expected", duration(predicted_ - before)));
}

/// Predicted cost of the scene, if the machine's costs were measured.
std::optional<Estimate> Run::foreseen(SceneFile file, const Plan& plan) const {
    const auto costs = find_coarse_run(file);
    if (!costs) return std::nullopt;
    // When the film is resumed its scene is this one.
    if (!request_.from) keep_coarse_run(read_resolved(scene_text_, "scene.resolved.toml"), *costs);
    if (request_.no_draw) file.scene.output.images = false;
    return estimate(file, plan, simulation_, *costs);
}

/// Seconds that each frame will take; empty if costs were not measured.
std::vector<double> Run::foreseen_frames(const Plan& plan) const {
    const auto e = foreseen(request_.file, plan);
    std::vector<double> frames = e ? e->frames_seconds : std::vector<double>();
    if (!frames.empty()) frames.resize(std::max(frames.size(), static_cast<std::size_t>(last_)), frames.back());
    return frames;
}

/// Choices for the whole film are stored in scene.resolved.toml and thus in every checkpoint: a resumed film keeps them.
SceneFile Run::chosen() const {
    check_probes(simulation_);
    SceneFile file = with_choices(request_.file, simulation_, watch_coarse_run(request_.quiet || request_.json));
    file.look.streak_time = film_streak_time(file.look, simulation_);
    return file;
}

void Run::make_folders() {
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

void Run::resume() {
    const Checkpoint& from = *request_.from;
    std::istringstream state(from.simulation);
    simulation_.load(state);
    replay_.apply_until(simulation_.time(), [&](const Scene& s, const Plan& p, double time) { simulation_.changed_before(s, p, time); });
    first_ = from.frame + 1;
    std::ifstream report(folder_.path() / "run.json");
    if (const auto earlier = nlohmann::json::parse(report, nullptr, false); earlier.is_object() && earlier.contains("first_troubles"))
        incidents_.add_earlier(earlier["first_troubles"]);
    times_.add_earlier(from);
}

std::shared_ptr<Checkpoint> Run::state() const {
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
    state->simulation.shrink_to_fit();  // it is kept until its picture is on disk
    return state;
}

void Run::set_pictures(const SceneFile& file) {
    snapshots_.emplace(simulation_, snapshot_fields(file, simulation_.world()));
    pictures_ = std::make_shared<const PictureOptions>(PictureOptions{file.surface, file.camera, file.look});
}

void Run::after_step(const StepReport& report, double began) {
    const long step = simulation_.totals().steps + (report.diverged ? 1 : 0);
    if (const std::string news = incidents_.add(report, scene_, began, step); !news.empty()) progress_->note(news);
    if (report.diverged) return;
    progress_->step(simulation_, frame_);
    if (replay_.apply_until(simulation_.time(), [&](const Scene& s, const Plan& p, double when) { simulation_.change(s, p, when); }))
        loop_->scene_changed(replay_.now());
}

/// The next frame. @return false if it was not reached
bool Run::simulate() {
    ++frame_;
    if (!times_.simulate([&] { return loop_->step_to(frame_time(scene_, frame_)); })) return false;
    add_frame();
    return true;
}

/// The frame's row, its lines in the probes' tables, and its picture on the way.
void Run::add_frame() {
    // Each second: found in each frame, it would take 15 % of a thread's time.
    const int frames_a_volume = std::max(1, static_cast<int>(std::lround(1 / scene_.time.frame_interval())));
    FrameSummary summary = loop_->measure_frame();
    if ((frame_ - 1) % frames_a_volume == 0) summary.measures.volume = coupled_volume(simulation_.world());
    tables_->add_frame(frame_, summary, times_.wall(), times_.cpu());
    const double now = wall_seconds(), seconds = now - std::exchange(frame_done_at_, now);
    if (scene_.budget.any() && summary.steps > 0) loop_->hold_to_budget(summary, frame_, seconds, times_.wall());
    const bool due = frame_ == last_ || wall_seconds() - saved_at_ >= scene_.output.checkpoint_every;
    film_->add(snapshots_->take(simulation_, frame_), pictures_, state(), due);
    if (due) {
        saved_at_ = wall_seconds();
        write_report("running", "");
    }
    progress_->frame_done(simulation_, frame_, summary.iterations);
    if (frame_ < last_) loop_->apply_governor();
}

void Run::write_report(const std::string& status, const std::string& message) {
    RunReport report;
    report.status = status, report.message = message;
    report.frames = frames_written();
    report.draws = film_options(request_, file_, 0).images;
    report.frames_planned = last_;
    report.wall = times_.wall(), report.cpu = times_.cpu(), report.resumed = times_.resumed(), report.predicted_wall = predicted_;
    report.first_picture = film_->first_picture() > 0 ? film_->first_picture() - times_.began() : 0;
    report.gl_device = film_->device();
    report.encoder = encoder_;
    report.stages = stages();
    report.incidents = incidents_;
    write_text(folder_.path() / "run.json", json_text(run_json(simulation_, report), 2) + "\n");
}

/// Saves the state of the last frame whose row and image are on disk.
void Run::save_newest() {
    if (const auto state = film_->newest_state()) write_checkpoint(folder_.path(), *state);
}

void Run::say_done(double wall) {
    if (const RunTotals& totals = simulation_.totals(); totals.unconverged_solves > 0)
        progress_->note(fmt::format("{} solves of {} steps ended before their tolerance (run.json: first_troubles)",
                                    totals.unconverged_solves, totals.steps));
    const bool video = scene_.output.images && scene_.output.video && !request_.no_draw;
    const std::string folder = folder_.path().string();
    const std::string expected = predicted_ > 0 ? fmt::format(" ({} expected)", duration(predicted_)) : "";
    progress_->say(fmt::format("{}, done in {}{}: {}", counted(frames_written(), "frame"), duration(wall), expected,
                               video ? folder + "/" + scene_.name + ".mp4" : folder));
}

void Run::print_result(const std::string& status, const std::string& message, double wall) const {
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

int Run::conclude(const std::string& status, const std::string& message) {
    if (film_options(request_, file_, 0).images) write_contact_sheet(folder_.path(), frames_written());
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

int Run::complete() {
    const std::optional<Divergence>& diverged = simulation_.world().report.diverged;
    const std::string folder = folder_.path().string();
    if (diverged) {
        film_->finish(true);
        const Vec3d& x = diverged->place;
        const int made = film_->frames_written();
        return conclude("diverged",
                        fmt::format("the run diverged at {:.6g} s in stage \"{}\"{}, field \"{}\", at ({:.4g}, {:.4g}, {:.4g}) m: {}; the "
                                    "{} before it {} in {}",
                                    diverged->time, diverged->stage, diverged->stage == "force" ? " (fluid.force)" : "", diverged->field,
                                    x.x(), x.y(), x.z(), diverged->what, counted(made, "frame"), made == 1 ? "is" : "are", folder));
    }
    const bool complete = simulation_.time() >= frame_time(scene_, last_);
    if (!complete) progress_->say("interrupted: completing the frames on their way");
    film_->finish(complete);
    if (complete) return conclude("done", "");
    save_newest();
    if (frames_written() == 0) return conclude("interrupted", "interrupted before the first frame");
    return conclude("interrupted", fmt::format("interrupted after frame {} of {}; continue with: whorl resume {}{}", frames_written(),
                                               last_, folder, request_.no_draw ? " --no-draw" : ""));
}

/// Does a part of the run. What was made stays where it throws.
template <class Work>
auto Run::keeping(const Work& work) try {
    return work();
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

bool Run::next() {
    return keeping([&] { return frame_ < last_ && simulate(); });
}
int Run::finish() {
    return keeping([&] { return complete(); });
}

}  // namespace

const char* without_video(bool goes_on) {
    return goes_on ? "or set output.video = false in scene.resolved.toml" : "or run with --no-video";
}

void check_video_rate(const Scene& scene) {
    if (scene.time.fps < least_video_fps)
        throw InputError(scene.place("time.fps"), fmt::format("time.fps = {:g}: too few frames a second for a video", scene.time.fps),
                         "set output.video = false", fmt::format("allowed: at least {:g}", least_video_fps));
}

std::unique_ptr<FramedRun> begin_run(const RunRequest& request) {
    const Plan plan = make_plan(request.file);
    if (!request.from) RunFolder::check_fresh(request.folder);  // not only after a coarse run
    std::string encoder;
    if (!film_options(request, request.file, 0).video.empty()) {
        check_video_rate(request.file.scene);
        encoder = check_encoder(without_video(request.from || request.earlier == RunFolder::Earlier::begun_again));
    } else if (request.file.scene.output.images && request.file.scene.output.video) encoder = encoder_version();
    return std::make_unique<Run>(request, plan, std::move(encoder));
}

int run_scene(const RunRequest& request) {
    const std::unique_ptr<FramedRun> run = begin_run(request);
    while (run->next()) {}
    return run->finish();
}

}  // namespace whorl

#include "tools/film/run.h"

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/core/whole_file.h"
#include "engine/io/columns.h"
#include "engine/io/snapshot.h"
#include "render/look/field_values.h"
#include "render/video/encoder.h"
#include "tools/cost/estimate.h"
#include "tools/film/colour_range.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/film.h"
#include "tools/film/governor.h"
#include "tools/film/interrupt.h"
#include "tools/film/panels.h"
#include "tools/film/progress.h"
#include "tools/film/report.h"
#include "tools/film/run_folder.h"
#include "tools/film/tables.h"
#include "tools/film/usage.h"
#include "tools/program/command.h"
#include "tools/program/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

FilmOptions film_options(const RunRequest& request, const SceneFile& file, int frames_before) {
    const Scene& scene = file.scene;
    FilmOptions options;
    options.folder = request.folder;
    options.images = scene.output.frames;
    if (scene.output.frames && scene.output.video) options.video = request.folder / (scene.name + ".mp4");
    options.exports = scene.output.exports;
    options.width = scene.output.size[0];
    options.height = scene.output.size[1];
    options.fps = scene.time.fps;
    options.frames_before = frames_before;
    return options;
}

/// What a frame needs besides positions and velocities.
std::vector<std::string> snapshot_fields(const SceneFile& file, const World& world) {
    std::vector<std::string> fields = shown_fields(file.look);
    const auto& exports = file.scene.output.exports;
    if (std::find(exports.begin(), exports.end(), "points") != exports.end())
        for (const std::string& name : live_fields(world.fluid))
            if (std::find(fields.begin(), fields.end(), name) == fields.end()) fields.push_back(name);
    return fields;
}

class Run {
public:
    Run(const RunRequest& request, const Plan& plan);
    int go();

private:
    SceneFile with_colour_range() const;
    void make_folders();
    void resume();

    void take_up(const SceneFile& file);
    void follow_changes();
    void land(int frame);
    std::optional<SceneFile> govern(int frame, const Measures& measures);
    void go_by(const SceneFile& file);
    bool step_to(int frame);
    std::shared_ptr<Checkpoint> state_at(int frame) const;
    std::optional<Divergence> loop();
    void save_newest();
    void predict_late();
    void write_report(const std::string& status, const std::string& message);
    int conclude(const std::string& status, const std::string& message);

    double wall() const { return earlier_wall_ + wall_seconds() - began_; }
    double cpu() const { return earlier_cpu_ + process_cpu_seconds() - cpu_before_; }
    StageTimes stages() const;

    const RunRequest& request_;
    const Scene& scene_;
    double began_ = wall_seconds(), earlier_wall_ = 0, earlier_cpu_ = 0;
    double cpu_before_ = process_cpu_seconds(), simulation_cpu_before_ = simulation_cpu_seconds();  ///< another panel may have run before
    StageTimes earlier_stages_;
    int resumed_ = 0;
    int first_ = 1, last_ = 1;  ///< frames that this part of the run makes
    Simulation simulation_;     ///< places fluid and solids: may throw InputError, so the folder comes after it
    SceneFile file_;            ///< the request's, with what is chosen at the start put in
    Replay replay_;             ///< what changes while the scene runs
    RunFolder folder_;
    std::shared_ptr<spdlog::logger> log_;
    std::string scene_text_;
    std::optional<RunTables> tables_;
    std::optional<Snapshots> snapshots_;
    std::shared_ptr<const PictureOptions> how_;
    RunTotals totals_at_row_;
    Troubles troubles_;
    std::optional<Governor> governor_;                          ///< where the scene has a budget
    double landed_at_ = wall_seconds(), largest_residual_ = 0;  ///< of the frame on its way
    long unconverged_at_row_ = 0;
    double saved_at_ = wall_seconds();
    double predicted_ = 0;  ///< s, wall time of the whole run where costs were measured before (whorl plan); else 0
    InterruptGuard interrupt_;
    std::optional<Progress> progress_;
    std::optional<Film> film_;
};

Run::Run(const RunRequest& request, const Plan& plan)
    : request_(request), scene_(request.file.scene), simulation_(scene_, plan), file_(with_colour_range()), replay_(file_),
      folder_(request.from ? RunFolder::existing(request.folder) : RunFolder::fresh(request.folder)), scene_text_(resolved_toml(file_)) {
    last_ = request.frames.value_or(frame_count(scene_));
    make_folders();
    if (request.from) resume();
    tables_.emplace(folder_.path(), simulation_, scene_.budget.any(), request.from ? &*request.from : nullptr);
    if (scene_.budget.any()) {
        governor_.emplace(replay_.now(), last_);
        if (request.from) governor_->set(tables_->last_given_up());
    }
    take_up(replay_.now());
    if (governor_ && governor_->now().amount > 0) go_by(governor_->governed());
    totals_at_row_ = simulation_.totals();
    log_->info("whorl {}, {}: frames {} to {}", build_id(), scene_.name, first_, last_);
    for (const Choice& c : plan.choices) log_->info("{} = {}{}: {}", c.key, c.value, c.automatic ? " (auto)" : "", c.reason);
    for (const std::string& warning : plan.warnings) log_->warn("{}", warning);
    progress_.emplace(first_, last_, request.quiet, request.json);
    for (const std::string& warning : plan.warnings) progress_->say("warning: " + warning);
    if (const auto costs = find_calibration(request.file, plan); costs && !request.from && !request.frames) {
        predicted_ = estimate(request.file, plan, simulation_, *costs).film;
        progress_->say(fmt::format("about {} expected", duration(predicted_)));
    }
    film_.emplace(film_options(request, file_, first_ - 1));
    write_report("running", "");
}

/// The range of the colour map stands in scene.resolved.toml and thereby in every checkpoint: a resumed film keeps it.
SceneFile Run::with_colour_range() const {
    SceneFile file = request_.file;
    if (shows_field(file.look)) file.look.range = film_range(file.look, simulation_);
    return file;
}

void Run::make_folders() {
    const auto& exports = scene_.output.exports;
    std::vector<std::string> names(exports.begin(), exports.end());
    if (scene_.output.frames) names.emplace_back("frames");
    if (!scene_.probes.empty()) names.emplace_back("probes");
    for (const std::string& name : names) fs::create_directories(folder_.path() / name);
    write_text(folder_.path() / "scene.resolved.toml", scene_text_);
    spdlog::drop("run");
    log_ = spdlog::basic_logger_mt("run", (folder_.path() / "log.txt").string());
    log_->flush_on(spdlog::level::info);
}

void Run::resume() {
    const Checkpoint& from = *request_.from;
    std::istringstream state(from.simulation);
    simulation_.load(state);
    replay_.make_until(simulation_.time(), [&](const Scene& s, const Plan& p, double time) { simulation_.changed_before(s, p, time); });
    first_ = from.frame + 1;
    std::ifstream report(folder_.path() / "run.json");
    if (const auto earlier = nlohmann::json::parse(report, nullptr, false); earlier.is_object() && earlier.contains("first_troubles"))
        troubles_.take(earlier["first_troubles"]);
    earlier_wall_ = from.wall, earlier_cpu_ = from.cpu, earlier_stages_ = from.stages, resumed_ = from.resumed + 1;
}

StageTimes Run::stages() const {
    StageTimes all = with_shared_cpu(simulation_.times(), simulation_cpu_seconds() - simulation_cpu_before_);
    all.merge(film_->times());
    for (const auto& [name, t] : earlier_stages_) {
        StageTime& sum = all[name];
        sum.wall += t.wall, sum.cpu += t.cpu, sum.calls += t.calls;
    }
    return all;
}

std::shared_ptr<Checkpoint> Run::state_at(int frame) const {
    auto state = std::make_shared<Checkpoint>();
    state->build = build_id();
    state->scene = scene_text_;
    state->frame = frame;
    state->frames = last_;
    state->wall = wall(), state->cpu = cpu(), state->stages = stages(), state->resumed = resumed_;
    tables_->save(*state);
    std::ostringstream particles;
    simulation_.save(particles);
    state->simulation = std::move(particles).str();
    return state;
}

/// From now on pictures are made as `file` says.
void Run::take_up(const SceneFile& file) {
    snapshots_.emplace(simulation_, snapshot_fields(file, simulation_.world()));
    how_ = std::make_shared<const PictureOptions>(PictureOptions{file.surface, file.camera, file.look});
}

void Run::follow_changes() {
    if (!replay_.make_until(simulation_.time(), [&](const Scene& s, const Plan& p, double) { simulation_.change(s, p); })) return;
    take_up(replay_.now());
    if (!governor_) return;
    governor_->want(replay_.now());
    if (governor_->now().amount > 0) go_by(governor_->governed());
}

/// From now on simulation and pictures go by what the governor allows. The models stay those that run.
void Run::go_by(const SceneFile& file) {
    const Scene scene = with_models_of(simulation_.plan(), file.scene);
    simulation_.change(scene, make_plan(scene));
    take_up(file);
}

/// What the frame took, and what the next one may. @return how to go on, where it is another way than before
std::optional<SceneFile> Run::govern(int frame, const Measures& measures) {
    const double now = wall_seconds(), seconds = now - landed_at_;
    landed_at_ = now;
    if (frame == first_ && !request_.from) return std::nullopt;  // nothing was simulated for it
    const Sacrifice before = governor_->now();
    auto next = governor_->look(seconds, frame, wall());
    tables_->add_budget(budget_row({frame, simulation_.time(), seconds, governor_->allowed(), before, largest_residual_,
                                    simulation_.totals().unconverged_solves - unconverged_at_row_, measures.density_error_mean,
                                    measures.density_error_max}));
    largest_residual_ = 0, unconverged_at_row_ = simulation_.totals().unconverged_solves;
    return frame < last_ ? next : std::nullopt;
}

/// The frame's row, its lines in the probes' tables, and its picture on the way.
void Run::land(int frame) {
    const double time = simulation_.time();
    const RunTotals& totals = simulation_.totals();
    const Measures measures = measure(simulation_.world(), simulation_.scene().domain.gravity(time), simulation_.plan().spin.micro_inertia);
    tables_->land(frame, measures, totals_at_row_, wall(), cpu());
    const double steps = static_cast<double>(std::max(1L, totals.steps - totals_at_row_.steps));
    const double iterations = (totals.pressure_iterations - totals_at_row_.pressure_iterations + totals.viscosity_iterations -
                               totals_at_row_.viscosity_iterations) /
                              steps;
    totals_at_row_ = totals;
    const std::optional<SceneFile> next = governor_ ? govern(frame, measures) : std::nullopt;

    const bool due = frame == last_ || wall_seconds() - saved_at_ >= scene_.output.checkpoint_every;
    film_->add(snapshots_->take(simulation_, frame), how_, state_at(frame), due);
    if (due) {
        saved_at_ = wall_seconds();
        write_report("running", "");
    }
    progress_->landed(simulation_, frame, iterations);
    if (next) go_by(*next);
}

/// @return false where the run was interrupted or diverged on the way
bool Run::step_to(int frame) {
    const double until = frame_time(scene_, frame);
    while (simulation_.time() < until) {
        if (interrupt_.interrupted()) return false;
        const double time = simulation_.time();
        const StepReport& report = simulation_.step(std::min(until, replay_.next()));
        for (const StepReport::Solve& solve : report.solves) largest_residual_ = std::max(largest_residual_, solve.report.last_residual);
        troubles_.look(report, time, simulation_.totals().steps + (report.diverged ? 1 : 0));
        if (report.diverged) return false;
        tables_->after_step();
        progress_->step(simulation_, frame);
        follow_changes();
    }
    return true;
}

std::optional<Divergence> Run::loop() {
    for (int frame = first_; frame <= last_; ++frame) {
        if (!step_to(frame)) return simulation_.world().report.diverged;
        land(frame);
    }
    return std::nullopt;
}

void Run::write_report(const std::string& status, const std::string& message) {
    RunReport report;
    report.status = status, report.message = message;
    report.frames = std::max(first_ - 1, film_->frames_written());
    report.frames_planned = last_;
    report.wall = wall(), report.cpu = cpu(), report.resumed = resumed_, report.predicted_wall = predicted_;
    report.first_picture = film_->first_picture() > 0 ? film_->first_picture() - began_ : 0;
    report.gl_device = film_->device();
    static const std::string encoder = encoder_version();
    report.encoder = scene_.output.frames && scene_.output.video ? encoder : "";
    report.stages = stages();
    report.troubles = troubles_;
    write_text(folder_.path() / "run.json", run_json(simulation_, report).dump(2) + "\n");
}

/// Saves the state of the newest frame whose row and picture are on disk.
void Run::save_newest() {
    if (const auto state = film_->newest_state()) write_checkpoint(folder_.path(), *state);
}

/// What the run was expected to take, where costs had not been measured when it began: then it began at once, and a run that took long
/// enough can spare the second that measuring takes.
void Run::predict_late() try {
    constexpr double spares_a_second = 30;
    if (predicted_ > 0 || request_.from || request_.frames || wall() < spares_a_second) return;
    const Plan plan = make_plan(request_.file.scene);
    predicted_ = estimate(request_.file, plan, Simulation(request_.file.scene, plan), calibrate(request_.file, plan)).film;
    // The rest of the report stands: the run took neither the time nor the memory of this.
    const std::filesystem::path file = folder_.path() / "run.json";
    auto report = nlohmann::ordered_json::parse(std::ifstream(file));
    report["predicted_wall_seconds"] = predicted_;
    write_text(file, report.dump(2) + "\n");
} catch (const std::exception& error) {  // the film is there, which is what counts
    log_->warn("no prediction: {}", error.what());
}

int Run::conclude(const std::string& status, const std::string& message) {
    const int frames = std::max(first_ - 1, film_->frames_written());
    if (scene_.output.frames) write_contact_sheet(folder_.path(), frames);
    write_report(status, message);
    const double took = wall();
    if (status == "done") predict_late();
    log_->info("{} after {} frames, {} steps, {:.1f} s{}{}", status, frames, simulation_.totals().steps, took, message.empty() ? "" : ": ",
               message);
    const std::string folder = folder_.path().string();
    if (status == "done") {
        const bool video = scene_.output.frames && scene_.output.video;
        const std::string expected = predicted_ > 0 ? fmt::format(" ({} expected)", duration(predicted_)) : "";
        progress_->say(fmt::format("{} frames, {} in {}{}: {}", frames, status, duration(took), expected,
                                   video ? folder + "/" + scene_.name + ".mp4" : folder));
    }
    if (request_.json) {
        const nlohmann::ordered_json result{{"event", "result"},
                                            {"status", status},
                                            {"message", message},
                                            {"folder", folder},
                                            {"frames", frames},
                                            {"time", simulation_.time()},
                                            {"particles", simulation_.world().fluid.size()},
                                            {"wall_seconds", took}};
        std::printf("%s\n", result.dump().c_str());
    }
    progress_.reset();
    if (status == "done") return exit_done;
    std::fprintf(stderr, "whorl: %s\n", message.c_str());
    return status == "interrupted" ? exit_interrupted : exit_failed;
}

int Run::go() try {
    const auto diverged = loop();
    if (diverged) {
        film_->finish(true);
        const Vec3d& x = diverged->place;
        return conclude("diverged",
                        fmt::format("the run diverged at {:.6g} s in stage \"{}\", field \"{}\", at ({:.4g}, {:.4g}, {:.4g}) m: {}; the "
                                    "{} frames before it are in {}",
                                    diverged->time, diverged->stage, diverged->field, x.x(), x.y(), x.z(), diverged->what,
                                    film_->frames_written(), folder_.path().string()));
    }
    if (simulation_.time() < frame_time(scene_, last_)) {
        progress_->say("interrupted: completing the frames on their way");
        film_->finish(false);
        save_newest();
        return conclude("interrupted", fmt::format("interrupted after frame {} of {}; go on with: whorl resume {}",
                                                   std::max(first_ - 1, film_->frames_written()), last_, folder_.path().string()));
    }
    film_->finish(true);
    return conclude("done", "");
} catch (const std::exception& error) {
    log_->error("{}", error.what());
    try {
        save_newest();
        write_report("failed", error.what());
    } catch (const std::exception&) {  // the disk is full, most likely: what stands there stays
    }
    throw;
}

}  // namespace

double frame_time(const Scene& scene, int frame) { return (frame - 1) * scene.time.frame_interval(); }

int frame_count(const Scene& scene) {
    // A hair more than the product, for ends that are a whole number of frames up to rounding.
    return static_cast<int>(std::floor(scene.time.end / scene.time.frame_interval() * (1 + 1e-12) + 1e-9)) + 1;
}

int run_scene(const RunRequest& request) {
    if (!request.file.scene.panels.empty()) return run_panels(request, PanelRuns::anew);
    const Plan plan = make_plan(request.file.scene);
    return Run(request, plan).go();
}

}  // namespace whorl

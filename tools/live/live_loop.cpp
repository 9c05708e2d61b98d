#include "tools/live/live_loop.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "engine/core/parallel.h"
#include "engine/scene/scene.h"
#include "render/look/field_values.h"
#include "render/look/overlay.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

/// Number of frames in the history, which are the points of the page's curves.
constexpr std::size_t kept_frames = 600;

Json finite(double v) { return std::isfinite(v) ? Json(v) : Json(); }

}  // namespace

void Status::set(Json json) {
    const std::lock_guard lock(mutex_);
    json_ = std::move(json);
    if (!history_.empty() && json_.at("frame") <= history_.back().at("frame")) {
        if (json_.at("frame") == history_.back().at("frame")) return;  // the same frame, reported again after a change
        history_.clear();                                              // the run was restarted
    }
    Json row = Json::object();
    for (const char* name : {"frame", "time", "ms", "frames_per_second", "iterations", "steps", "energy", "probes"})
        row[name] = json_.at(name);
    history_.push_back(std::move(row));
    if (history_.size() > kept_frames) history_.pop_front();
}

LiveLoop::LiveLoop(Controls& controls, LiveRenderer& live_renderer, ChangeRecording& recording, Status& status, bool real_time,
                   std::function<void(const std::string&)> say)
    : controls_(controls), live_renderer_(live_renderer), recording_(recording), status_(status), real_time_(real_time),
      say_(std::move(say)) {
    follow(controls_.take(0));
}

void LiveLoop::begin(PlannedScene& scene) {
    loop_.reset();
    simulation_ = std::move(scene.simulation);
    frame_ = 1;
    state_ = State::running;
    why_.clear();
    incidents_ = {};
    probed_ = profiles_ = plots_ = Json::object();
    comparisons_.clear();
    times_before_ = {}, frame_times_ = {};
    frame_steps_ = 0, frame_iterations_ = frame_wall_ = simulate_wall_ = 0;
    played_ = play_wall_ = 0;
    {
        const std::lock_guard lock(recording_mutex_);
        recording_.begin(scene.file, controls_.scene_path(), controls_.options().quality);
        recording_.write(0);
        time_ = 0;
    }
    loop_.emplace(*this, *simulation_, scene.file, frame_count(scene.file.scene), TheorySearch::in_background);
    for (const auto& [name, probe] : loop_->probes()) {
        comparisons_.push_back(comparison_of(scene.file.scene, comparisons_.size(), *probe));
        plots_[name] = described_plots(*probe, comparisons_.back());
    }
    snapshots_.emplace(*simulation_, shown_fields(scene.file.look));
    stepped_ = revision_;
    set_pictures(scene.file);
    budget_.reset();
    std::filesystem::remove(recording_.folder() / "budget.csv");  // of the previous run
    spent_ = 0;
    shown_at_ = due_ = wall_seconds();
    show_frame();
}

void LiveLoop::set_pictures(const SceneFile& file) { live_renderer_.look({file.surface, file.camera, file.look}, look_); }

void LiveLoop::follow(const Orders& orders) {
    if (!orders.scene) return;
    PlannedScene& wanted = *orders.scene;
    const auto before = std::exchange(followed_, orders.scene);
    const bool physics = !before || wanted.simulation || decides(before->file, wanted.file);
    look_ = orders.picture_revision;
    if (physics) revision_ = orders.revision;
    if (!wanted.simulation && simulation_->totals().steps == 0 && physics) try {
            // No step was made yet: start again from the new values. The recording then has them as initial values.
            wanted.simulation = std::make_unique<Simulation>(wanted.file.scene, wanted.plan);
        } catch (const InputError&) {  // a solid was moved into the fluid: apply the change to the running simulation instead
        }
    if (wanted.simulation) return begin(wanted);
    if (state_ == State::diverged) return;  // only a restart can continue the run; it uses these values
    const double time = simulation_->time();
    if (physics) simulation_->change(wanted.file.scene, wanted.plan);
    const bool other_fields = shown_fields(before->file.look) != shown_fields(wanted.file.look);
    if (physics || other_fields) {
        Snapshots now(*simulation_, shown_fields(wanted.file.look));
        now.share_meshes(*snapshots_);
        snapshots_ = std::move(now);
    }
    if (other_fields) show_state();
    {
        const std::lock_guard lock(recording_mutex_);
        recording_.add(time, orders.changes);
        recording_.write(time);
    }
    end_if_over(wanted.file.scene);
    loop_->scene_changed(wanted.file);
    report_state();
}

/// Wall time of the last frame [s]: the longer of simulating and drawing, which run in parallel.
double LiveLoop::frame_seconds() const {
    double picture = 0;
    for (const auto& [name, t] : live_renderer_.times()) picture += t.wall;
    return std::max(simulate_wall_, picture);
}

void LiveLoop::after_step(const StepReport& report, double began) {
    const std::string news = incidents_.add(report, simulation_->scene(), began, simulation_->totals().steps);
    if (!news.empty()) controls_.report(false, news);
    if (report.diverged) {
        const Divergence& d = *report.diverged;
        state_ = State::diverged;
        why_ = fmt::format("diverged at {:.4g} s in \"{}\", {}: {}; undo the last changes and restart", d.time, d.stage, d.field, d.what);
        controls_.report(true, why_);
        return;
    }
    const double now = wall_seconds();
    step_wall_ = now - std::exchange(step_began_, now);
    stepped_ = revision_;
    const bool reached = simulation_->time() >= frame_time(simulation_->scene(), frame_ + 1);
    const Orders orders = controls_.take_changes();
    // If a change waits, an image of this state would delay the image that shows the change.
    if (!reached && (stepped_ > shown_ || (!orders.scene && live_renderer_.wants_state_within(step_wall_)))) show_state();
    follow(orders);
}

void LiveLoop::show_state() {
    live_renderer_.show(snapshots_->take(*simulation_, frame_), stepped_);
    shown_ = stepped_;
}

/// @return false if the run ends, restarts or diverges before the frame time
bool LiveLoop::step_to_next_frame() {
    const double began = step_began_ = wall_seconds();
    if (!loop_->step_to(frame_time(simulation_->scene(), frame_ + 1))) return false;
    simulate_wall_ = wall_seconds() - began;
    ++frame_;
    return true;
}

/// Measures, shows and reports the frame that has been reached.
void LiveLoop::show_frame() {
    const FrameSummary summary = loop_->measure_frame();
    frame_steps_ = summary.steps, frame_iterations_ = summary.iterations;
    frame_times_.clear();
    for (const auto& [name, t] : simulation_->times()) frame_times_[name].wall = t.wall - times_before_[name].wall;
    times_before_ = simulation_->times();
    for (std::size_t k = 0; k < comparisons_.size(); ++k) {
        const auto& [name, probe] = loop_->probes()[k];
        const ProbeRows rows = rows_of(*probe, *simulation_);
        probed_[name] = newest_row(*probe, rows, comparisons_[k]);
        if (probe->along() != 0) profiles_[name] = profile_of(*probe, rows, comparisons_[k]);
    }
    {
        const std::lock_guard lock(recording_mutex_);
        time_ = simulation_->time();
    }
    show_state();
    const double now = wall_seconds();
    frame_wall_ = now - std::exchange(shown_at_, now);
    if (frame_steps_ > 0 && frame_wall_ > 0) {
        const double frame = 1 / simulation_->scene().time.fps, kept = std::exp(-frame_wall_);
        played_ = kept * played_ + frame, play_wall_ = kept * play_wall_ + frame_wall_;
        live_renderer_.set_interval(frame);
        say_pace();
    }
    end_if_over(simulation_->scene());
    if (summary.steps > 0) {
        const double seconds = frame_seconds();
        if (const std::string row = loop_->hold_to_budget(summary, frame_, seconds, spent_ += seconds); !row.empty()) {
            if (!budget_) budget_ = std::make_unique<Table>(recording_.folder() / "budget.csv", budget_header());
            budget_->append(row);
        }
        if (state_ == State::running) loop_->apply_governor();
    }
    status_.set(status_json(summary.measures));
}

/// Ends the run if the next frame would lie beyond time.end. Resumes it after time.end was raised.
void LiveLoop::end_if_over(const Scene& scene) {
    const bool over = frame_time(scene, frame_ + 1) > scene.time.end * (1 + 1e-9);
    const State before = std::exchange(state_, over ? State::ended : State::running);
    if (over && before != State::ended)
        controls_.report(false, fmt::format("the scene ends at {:g} s; raise time.end to continue, or restart", scene.time.end));
}

/// Reports the current state, even between two frames.
void LiveLoop::report_state() {
    const Vec3d gravity = simulation_->scene().domain.gravity(simulation_->time());
    status_.set(status_json(measure(simulation_->world(), gravity, simulation_->plan().spin.micro_inertia)));
}

Json LiveLoop::status_json(const Measures& m) const {
    const Scene& scene = simulation_->scene();
    Json ms = Json::object();
    for (const auto& [name, t] : frame_times_) ms[name] = 1e3 * t.wall;
    for (const auto& [name, t] : live_renderer_.times()) ms[name] = 1e3 * t.wall;
    const RunTotals& totals = simulation_->totals();
    const Governor& governor = loop_->governor();
    const QualityReduction s = governor.now();
    const Json given_up = {
        {"amount", s.amount}, {"tolerance_factor", s.tolerance}, {"cfl", s.cfl}, {"voxel", s.voxel}, {"samples", s.samples}};
    return {{"scene", scene.name},
            {"time", simulation_->time()},
            {"end", scene.time.end},
            {"frame", frame_},
            {"state", state_ == State::running ? "running"
                      : state_ == State::ended ? "ended"
                                               : "diverged"},
            {"problem", why_},
            {"particles", m.particles},
            {"ms", ms},
            {"simulate_ms", 1e3 * simulate_wall_},
            {"frame_ms", 1e3 * frame_wall_},
            {"frames_per_second", of_real_time() * scene.time.fps},
            {"simulated_per_wall_second", of_real_time() / scene.time.slow_motion},
            {"pace", pace_text()},
            {"steps", frame_steps_},
            {"time_step", totals.last_step},
            {"iterations", frame_iterations_},
            {"energy", {{"kinetic", finite(m.kinetic_energy)}, {"potential", finite(m.potential_energy)}, {"spin", finite(m.spin_energy)}}},
            {"max_speed", finite(m.max_speed)},
            {"density_error", finite(m.density_error_max)},
            {"given_up", given_up},
            {"frame_seconds_allowed", governor.has_budget() ? finite(governor.allowed()) : Json()},
            {"largest_residual", finite(loop_->largest_residual())},
            {"lost_particles", totals.lost_particles},
            {"probes", probed_},
            {"profiles", profiles_},
            {"probe_plots", plots_}};
}

/// Message with the pace and the wall times of simulation and image; empty if the run keeps up with real time.
std::string LiveLoop::pace_text() const {
    if (!real_time_ || of_real_time() == 0 || of_real_time() >= 0.97) return "";
    double picture = 0;
    for (const auto& [name, t] : live_renderer_.times())
        if (name != "encode") picture += t.wall;
    const TimeKeys& time = simulation_->scene().time;
    return fmt::format("{:.2f} of {}: for a frame of {:.0f} ms, the simulation needs {:.0f} ms and an image {:.0f} ms", of_real_time(),
                       time.slow_motion == 1 ? "real time" : "the video's pace", 1e3 / time.fps, 1e3 * simulate_wall_, 1e3 * picture);
}

/// Prints the pace when it has changed by at least a tenth of real time, at most every 10 s.
void LiveLoop::say_pace() {
    constexpr double often = 10, much = 0.1;  // least interval [s]; least change of the pace
    const double factor = std::min(1.0, of_real_time()), now = wall_seconds();
    if (!say_ || !real_time_ || now - said_at_ < often || std::abs(factor - said_) < much) return;
    const std::string text = pace_text();
    say_(text.empty() ? "in real time" : text);
    said_ = factor, said_at_ = now;
}

/// Waits until the next frame is due, so that the run is not faster than the video would play. A change ends the wait; if the loop took a
/// change after the last step, it does not wait.
void LiveLoop::wait_for_real_time() {
    if (!real_time_) return;
    const double frame = 1 / simulation_->scene().time.fps, now = wall_seconds();
    due_ = std::max(due_ + frame, now - 0.1);  // missed frames are not caught up
    if (due_ > now && revision_ == stepped_) controls_.wait_for_change(due_ - now);
}

void LiveLoop::run(const std::function<bool()>& stop) {
    stop_ = stop;
    while (!stop()) {
        live_renderer_.check();
        if (!live_renderer_.after(0, 0.1)) continue;  // wait for the first image, which takes long, so that viewers see the start
        const Orders orders = controls_.take(0.1);
        follow(orders);
        if (state_ != State::running || !(orders.playing || orders.step)) {
            due_ = shown_at_ = wall_seconds();
            continue;
        }
        if (step_to_next_frame()) {
            show_frame();
            wait_for_real_time();
        } else if (state_ == State::diverged) {
            report_state();
        }
    }
    save_recording();
}

std::string LiveLoop::save_recording() const {
    const std::lock_guard lock(recording_mutex_);
    recording_.write(time_);
    return recording_.text(time_);
}

namespace {

const std::string compared = "compare_";

/// A row of a probe with the comparison's columns. NaN becomes null.
Json row_json(const Probe& probe, const std::vector<double>& row, const std::optional<Comparison>& comparison) {
    const ProbeColumns columns = probe.columns();
    Json all = Json::object();
    for (std::size_t k = 0; k < columns.size(); ++k) all[columns[k].name] = row[k];
    if (!comparison) return all;
    for (const ProbePlot& plot : plots_of(columns))
        for (const ProbePlot::Curve& curve : plot.curves)
            if (const std::string& name = columns[curve.column].name; comparison->has(name))
                all[compared + name] = comparison->at(name, row[probe.along()]);
    return all;
}

}  // namespace

Json described_plots(const Probe& probe, const std::optional<Comparison>& comparison) {
    const ProbeColumns columns = probe.columns();
    Json plots = Json::array();
    for (const ProbePlot& plot : plots_of(columns)) {
        Json curves = Json::array();
        for (const ProbePlot::Curve& c : plot.curves)
            curves.push_back({{"column", columns[c.column].name}, {"label", c.label}, {"dashed", c.theory}});
        for (const ProbePlot::Curve& c : plot.curves)
            if (const std::string& name = columns[c.column].name; comparison && comparison->has(name))
                curves.push_back({{"column", compared + name},
                                  {"label", comparison->name + (plot.curves.size() > 1 ? ", " + c.label : "")},
                                  {"dashed", true}});
        plots.push_back({{"title", axis_title(plot.title, plot.unit)}, {"curves", curves}});
    }
    return {{"profile", probe.along() != 0},
            {"along", columns[probe.along()].name},
            {"along_unit", columns[probe.along()].unit},
            {"plots", plots}};
}

Json newest_row(const Probe& probe, const ProbeRows& rows, const std::optional<Comparison>& comparison) {
    return rows.empty() ? Json::object() : row_json(probe, rows.back(), comparison);
}

Json profile_of(const Probe& probe, const ProbeRows& rows, const std::optional<Comparison>& comparison) {
    constexpr std::size_t most = 200;
    Json all = Json::object();
    for (std::size_t k = 0; k < rows.size(); k += 1 + rows.size() / most) {
        const Json row = row_json(probe, rows[k], comparison);
        for (const auto& [name, value] : row.items()) all[name].push_back(value);
    }
    return all;
}

}  // namespace whorl

#include "tools/live/loop.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>
#include <thread>

#include "render/look/field_values.h"
#include "tools/film/run.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

/// The newest line of a probe's table as {"frequency": 2.1, ...}; empty cells are null.
Json last_row(const std::string& header, const std::string& rows) {
    Json row = Json::object();
    if (rows.empty()) return row;
    const std::size_t end = rows.size() - 1, begin = rows.rfind('\n', end - 1) + 1;
    std::istringstream names(header), cells(rows.substr(begin, end - begin));
    for (std::string name, cell; std::getline(names, name, ',');) {
        if (!std::getline(cells, cell, ',')) cell.clear();
        double value = 0;
        const auto read = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        row[name] = !cell.empty() && read.ec == std::errc() && std::isfinite(value) ? Json(value) : Json();
    }
    return row;
}

/// Mean that follows within a few frames.
void follow(double& mean, double value) { mean = mean > 0 ? 0.8 * mean + 0.2 * value : value; }

Json finite(double v) { return std::isfinite(v) ? Json(v) : Json(); }

}  // namespace

void Status::set(Json json) {
    const std::lock_guard lock(mutex_);
    json_ = std::move(json);
}
Json Status::get() const {
    const std::lock_guard lock(mutex_);
    return json_;
}

LiveLoop::LiveLoop(Wishes& wishes, Screen& screen, Journal& journal, Status& status, bool real_time)
    : wishes_(wishes), screen_(screen), journal_(journal), status_(status), real_time_(real_time) {
    begin(*wishes_.take(0).scene);
}

void LiveLoop::begin(WantedScene& scene) {
    simulation_ = std::move(scene.simulation);
    frame_ = 1;
    state_ = State::running;
    why_.clear();
    probes_.clear();
    probed_ = Json::object();
    for (const ProbeKeys& keys : scene.file.scene.probes)
        probes_.emplace_back(keys.name, make_probe(keys, simulation_->world(), Patience::never_waits));
    snapshots_.emplace(*simulation_, shown_fields(scene.file.look));
    times_before_ = {}, frame_times_ = {}, totals_before_ = simulation_->totals();
    frame_steps_ = 0, frame_iterations_ = frame_wall_ = simulate_wall_ = pace_ = frames_a_second_ = 0;
    {
        const std::lock_guard lock(recording_mutex_);
        journal_.begin(scene.file, wishes_.scene_path(), wishes_.options().quality);
        journal_.write(0);
        time_ = 0;
    }
    screen_.look({scene.file.surface, scene.file.camera, scene.file.look});
    governor_.emplace(scene.file, frame_count(scene.file.scene));
    budget_.reset();
    std::filesystem::remove(journal_.folder() / "budget.csv");  // of the run before
    spent_ = 0, unconverged_at_row_ = 0;
    landed_at_ = due_ = wall_seconds();
    land();
}

void LiveLoop::take_up(const Orders& orders) {
    if (!orders.scene) return;
    WantedScene& wanted = *orders.scene;
    if (!wanted.simulation && simulation_->totals().steps == 0) try {
            // Nothing has moved yet: a scene that begins with these values, which is what a recording will say.
            wanted.simulation = std::make_unique<Simulation>(wanted.file.scene, wanted.plan);
        } catch (const InputError&) {  // a solid moved over the fluid: from where it stands, then
        }
    if (wanted.simulation) return begin(wanted);
    if (state_ == State::diverged) return;  // stopped between two landings: only a restart helps, and has these values
    const double time = simulation_->time();
    simulation_->change(wanted.file.scene, wanted.plan);
    snapshots_.emplace(*simulation_, shown_fields(wanted.file.look));
    {
        const std::lock_guard lock(recording_mutex_);
        journal_.add(time, orders.changes);
        journal_.write(time);
    }
    if (state_ == State::ended && time < wanted.file.scene.time.end) state_ = State::running;
    screen_.look({wanted.file.surface, wanted.file.camera, wanted.file.look});
    governor_->want(wanted.file);
    if (governor_->now().amount > 0) go_by(governor_->governed());
    tell();
}

void LiveLoop::go_by(const SceneFile& governed) {
    const Scene scene = with_models_of(simulation_->plan(), governed.scene);
    simulation_->change(scene, make_plan(scene));
    screen_.look({governed.surface, governed.camera, governed.look});
}

/// Keeps to the scene's budget of time from the next frame on, and notes what this one took, gave up and lost by it.
void LiveLoop::govern(const Measures& measures) {
    double picture = 0;  // s, beside the simulation
    for (const auto& [name, t] : screen_.times()) picture += t.wall;
    const double seconds = std::max(simulate_wall_, picture);
    spent_ += seconds;
    const Sacrifice before = governor_->now();
    const auto next = governor_->look(seconds, frame_, spent_);
    const long unconverged = simulation_->totals().unconverged_solves;
    if (governor_->has_budget()) {
        if (!budget_) budget_ = std::make_unique<Table>(journal_.folder() / "budget.csv", budget_header());
        budget_->append(budget_row({frame_, simulation_->time(), seconds, governor_->allowed(), before, largest_residual_,
                                    unconverged - unconverged_at_row_, measures.density_error_mean, measures.density_error_max}));
    }
    unconverged_at_row_ = unconverged;
    if (next && state_ == State::running) go_by(*next);
}

/// @return false where it was broken off, to end or to begin anew
bool LiveLoop::step_to_frame(const std::function<bool()>& stop) {
    const Scene& scene = simulation_->scene();
    const double until = frame_time(scene, frame_ + 1), began = wall_seconds();
    while (simulation_->time() < until) {
        if (stop() || wishes_.restart_wanted()) return false;
        const StepReport& report = simulation_->step(until);
        if (report.diverged) {
            const Divergence& d = *report.diverged;
            state_ = State::diverged;
            why_ = fmt::format("diverged at {:.4g} s in \"{}\", {}: {}; undo what led there and restart", d.time, d.stage, d.field, d.what);
            wishes_.tell(true, why_);
            return false;
        }
        for (const StepReport::Solve& solve : report.solves) largest_residual_ = std::max(largest_residual_, solve.report.last_residual);
        for (auto& [name, probe] : probes_) probe->after_step(simulation_->world(), simulation_->time());
    }
    simulate_wall_ = wall_seconds() - began;
    ++frame_;
    return true;
}

/// The frame that has been reached: measured, shown, told.
void LiveLoop::land() {
    const RunTotals& totals = simulation_->totals();
    frame_steps_ = totals.steps - totals_before_.steps;
    const double iterations =
        totals.pressure_iterations + totals.viscosity_iterations - totals_before_.pressure_iterations - totals_before_.viscosity_iterations;
    frame_iterations_ = iterations / static_cast<double>(std::max(1L, frame_steps_));
    totals_before_ = totals;
    frame_times_.clear();
    for (const auto& [name, t] : simulation_->times()) frame_times_[name].wall = t.wall - times_before_[name].wall;
    times_before_ = simulation_->times();
    for (const auto& [name, probe] : probes_) {
        const Json row = last_row(probe->header(), rows_of(*probe, *simulation_));
        probed_[name] = row;
    }
    {
        const std::lock_guard lock(recording_mutex_);
        time_ = simulation_->time();
    }
    screen_.show(snapshots_->take(*simulation_, frame_));
    const double now = wall_seconds();
    frame_wall_ = now - landed_at_;
    landed_at_ = now;
    const double interval = simulation_->scene().time.frame_interval();
    if (frame_steps_ > 0 && frame_wall_ > 0) follow(pace_, interval / frame_wall_), follow(frames_a_second_, 1 / frame_wall_);
    if (frame_time(simulation_->scene(), frame_ + 1) > simulation_->scene().time.end * (1 + 1e-9)) {
        state_ = State::ended;
        wishes_.tell(false, fmt::format("the scene ends at {:g} s: raise time.end to go on, or restart", simulation_->scene().time.end));
    }
    const Measures now_measured = measures();
    if (frame_steps_ > 0) govern(now_measured);
    tell(now_measured);
    largest_residual_ = 0;
}

Measures LiveLoop::measures() const {
    return measure(simulation_->world(), simulation_->scene().domain.gravity(simulation_->time()), simulation_->plan().spin.micro_inertia);
}

void LiveLoop::tell() { tell(measures()); }

void LiveLoop::tell(const Measures& m) {
    const Scene& scene = simulation_->scene();
    const double time = simulation_->time();
    Json ms = Json::object();
    for (const auto& [name, t] : frame_times_) ms[name] = 1e3 * t.wall;
    const RunTotals& totals = simulation_->totals();
    const Sacrifice s = governor_->now();
    const Json given_up = {
        {"amount", s.amount}, {"tolerance_factor", s.tolerance}, {"cfl", s.cfl}, {"voxel", s.voxel}, {"samples", s.samples}};
    status_.set(
        {{"scene", scene.name},
         {"time", time},
         {"end", scene.time.end},
         {"frame", frame_},
         {"state", state_ == State::running ? "running"
                   : state_ == State::ended ? "ended"
                                            : "diverged"},
         {"particles", m.particles},
         {"ms", ms},
         {"simulate_ms", 1e3 * simulate_wall_},
         {"frame_ms", 1e3 * frame_wall_},
         {"frames_per_second", frames_a_second_},
         {"simulated_per_wall_second", pace_},
         {"steps", frame_steps_},
         {"time_step", totals.last_step},
         {"iterations", frame_iterations_},
         {"energy", {{"kinetic", finite(m.kinetic_energy)}, {"potential", finite(m.potential_energy)}, {"spin", finite(m.spin_energy)}}},
         {"max_speed", finite(m.max_speed)},
         {"density_error", finite(m.density_error_max)},
         {"given_up", given_up},
         {"frame_seconds_allowed", governor_->has_budget() ? finite(governor_->allowed()) : Json()},
         {"largest_residual", finite(largest_residual_)},
         {"lost_particles", totals.lost_particles},
         {"probes", probed_}});
}

/// A film's frames do not come faster than it plays.
void LiveLoop::wait_for_real_time() {
    if (!real_time_) return;
    const double frame = 1 / simulation_->scene().time.fps, now = wall_seconds();
    due_ = std::max(due_ + frame, now - 0.1);  // what was missed is not made up for
    if (due_ > now) std::this_thread::sleep_for(std::chrono::duration<double>(due_ - now));
}

void LiveLoop::run(const std::function<bool()>& stop) {
    while (!stop()) {
        screen_.check();
        const Orders orders = wishes_.take(0.1);
        take_up(orders);
        if (state_ != State::running || !(orders.playing || orders.step)) {
            due_ = landed_at_ = wall_seconds();
            continue;
        }
        if (step_to_frame(stop)) {
            land();
            wait_for_real_time();
        } else if (state_ == State::diverged) {
            tell();
        }
    }
    save_recording();
}

std::string LiveLoop::save_recording() const {
    const std::lock_guard lock(recording_mutex_);
    journal_.write(time_);
    return journal_.text(time_);
}

}  // namespace whorl

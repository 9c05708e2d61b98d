#include "tools/film/report.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/core/parallel.h"
#include "engine/core/version.h"

namespace whorl {

using Json = nlohmann::ordered_json;

Json choices_json(const Plan& plan) {
    Json all = Json::array();
    for (const Choice& c : plan.choices)
        all.push_back({{"key", c.key}, {"value", c.value}, {"automatic", c.automatic}, {"reason", c.reason}});
    return all;
}

Json run_json(const Simulation& simulation, const RunReport& report) {
    Json stages = Json::object();
    for (const auto& [name, t] : report.stages) stages[name] = {{"wall_seconds", t.wall}, {"cpu_seconds", t.cpu}, {"calls", t.calls}};
    const RunTotals& totals = simulation.totals();
    const double steps = static_cast<double>(std::max(1L, totals.steps));
    return {{"whorl", WHORL_VERSION},
            {"build", build_id()},
            {"scene", simulation.scene().name},
            {"status", report.status},
            {"message", report.message},
            {"draws", report.draws},
            {"machine",
             {{"processor", processor_name()},
              {"cores", omp_get_num_procs()},
              {"threads", threads()},
              {"memory_bytes", total_memory()},
              {"gl", report.gl_device},
              {"encoder", report.encoder}}},
            {"models", choices_json(simulation.plan())},
            {"warnings", simulation.plan().warnings},
            {"frames", report.frames},
            {"frames_planned", report.frames_planned},
            {"frames_of_scene", frame_count(simulation.scene())},
            {"time", simulation.time()},
            {"steps", totals.steps},
            {"particles", simulation.world().fluid.size()},
            {"particle_steps", totals.particle_steps},
            {"lost_particles", totals.lost_particles},
            {"emitted_particles", totals.emitted_particles},
            {"drained_particles", totals.drained_particles},
            {"iterations", {{"pressure", totals.pressure_iterations}, {"viscosity", totals.viscosity_iterations}}},
            {"iterations_per_step", {{"pressure", totals.pressure_iterations / steps}, {"viscosity", totals.viscosity_iterations / steps}}},
            {"pressure_solver",
             {{"levels", totals.pressure_levels},
              {"last_residual", totals.pressure_residual},
              {"set_up_seconds", totals.pressure_set_up},
              {"solve_seconds", totals.pressure_solve}}},
            {"unconverged_solves", totals.unconverged_solves},
            {"converged", totals.unconverged_solves == 0},
            {"first_troubles", report.incidents.json()},
            {"time_step_limits", totals.binding},
            {"wall_seconds", report.wall},
            {"predicted_wall_seconds", report.predicted_wall > 0 ? Json(report.predicted_wall) : Json()},
            {"cpu_seconds", report.cpu},
            {"resumed", report.resumed},
            {"stages", stages},
            {"peak_memory_bytes", peak_memory()}};
}

RunTimes::RunTimes() : began_(wall_seconds()), cpu_before_(process_cpu_seconds()) {}

void RunTimes::add_earlier(const Checkpoint& checkpoint) {
    earlier_wall_ = checkpoint.wall, earlier_cpu_ = checkpoint.cpu;
    earlier_stages_ = checkpoint.stages;
    resumed_ = checkpoint.resumed + 1;
}

double RunTimes::wall() const { return earlier_wall_ + wall_seconds() - began_; }
double RunTimes::cpu() const { return earlier_cpu_ + process_cpu_seconds() - cpu_before_; }

StageTimes RunTimes::stages(const StageTimes& simulation, const StageTimes& film) const {
    StageTimes all = simulation, of_film = film;
    // Divides the CPU time of the simulation's threads among the stages in proportion to wall time. A measurement of each stage would
    // include the threads that draw at the same time.
    double wall = 0;
    for (const auto& [name, t] : all) wall += t.wall;
    for (auto& [name, t] : all) t.cpu = wall > 0 ? simulation_cpu_ * t.wall / wall : 0;
    all.merge(of_film);
    for (const auto& [name, t] : earlier_stages_) {
        StageTime& sum = all[name];
        sum.wall += t.wall, sum.cpu += t.cpu, sum.calls += t.calls;
    }
    return all;
}

bool RunProblems::add(Incident incident) {
    // Each full room is a separate problem; the text before " at " names the room.
    const auto room = [](const Incident& i) { return i.kind == "full" ? i.what.substr(0, i.what.find(" at ")) : ""; };
    if (std::any_of(first_.begin(), first_.end(), [&](const Incident& i) { return i.kind == incident.kind && room(i) == room(incident); }))
        return false;
    first_.push_back(std::move(incident));
    return true;
}

std::string RunProblems::add(const StepReport& report, const Scene& scene, double time, long step) {
    std::string news;
    for (const StepReport::Solve& solve : report.solves)
        if (const SolveReport& r = solve.report; solve.kind == SolveKind::crowding) add(Incident{"crowded", time, step, r.why_not});
        else if (!r.converged) {
            const bool viscous = solve.kind == SolveKind::viscosity;
            const bool limited = solve.kind != SolveKind::heat &&
                                 r.iterations >= (viscous ? scene.viscosity.limits.max_iterations : scene.pressure.limits.max_iterations);
            const std::string what =
                fmt::format("{}: residual {:.2g} (from {:.2g}) after {} iterations{}{}", name_of(solve.kind), r.last_residual,
                            r.first_residual, r.iterations, r.why_not.empty() ? "" : ", " + r.why_not,
                            limited ? fmt::format("; raise {}.max_iterations", viscous ? "viscosity" : "pressure") : "");
            if (add(Incident{"unconverged", time, step, what})) news = fmt::format("unfinished solve at {:.4g} s: {}", time, what);
        }
    if (!report.full.empty() && add(Incident{"full", time, step, report.full})) news += (news.empty() ? "" : "\n") + report.full;
    if (report.lost_particles > 0)
        add(Incident{"lost", time, step, fmt::format("{} particles left the domain in one step", report.lost_particles)});
    if (const auto& d = report.diverged)
        add(Incident{"diverged", d->time, step,
                     fmt::format("stage \"{}\", field \"{}\" at ({:.4g}, {:.4g}, {:.4g}) m: {}", d->stage, d->field, d->place.x(),
                                 d->place.y(), d->place.z(), d->what)});
    return news;
}

Json RunProblems::json() const {
    Json all = Json::array();
    for (const Incident& t : first_) all.push_back({{"kind", t.kind}, {"time", t.time}, {"step", t.step}, {"what", t.what}});
    return all;
}

void RunProblems::add_earlier(const nlohmann::json& earlier) {
    for (const auto& t : earlier) add(Incident{t.value("kind", ""), t.value("time", 0.0), t.value("step", 0L), t.value("what", "")});
}

}  // namespace whorl

#include "tools/film/report.h"

#include <omp.h>

#include <nlohmann/json.hpp>

#include "engine/core/parallel.h"
#include "engine/core/version.h"
#include "engine/io/checkpoint.h"
#include "engine/scene/frame_times.h"
#include "tools/process/usage.h"

namespace whorl {

nlohmann::ordered_json run_json(const Simulation& simulation, const RunReport& report) {
    using Json = nlohmann::ordered_json;
    Json models = Json::array();
    for (const Choice& c : simulation.plan().choices)
        models.push_back({{"key", c.key}, {"value", c.value}, {"automatic", c.automatic}, {"reason", c.reason}});
    Json stages = Json::object();
    for (const auto& [name, t] : report.stages) stages[name] = {{"wall_seconds", t.wall}, {"cpu_seconds", t.cpu}, {"calls", t.calls}};
    const RunTotals& totals = simulation.totals();
    const double steps = static_cast<double>(std::max(1L, totals.steps));
    return {{"whorl", WHORL_VERSION},
            {"build", build_id()},
            {"scene", simulation.scene().name},
            {"status", report.status},
            {"message", report.message},
            {"machine",
             {{"processor", processor_name()},
              {"cores", omp_get_num_procs()},
              {"threads", threads()},
              {"memory_bytes", total_memory()},
              {"gl", report.gl_device},
              {"encoder", report.encoder}}},
            {"models", models},
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
            {"first_picture_seconds", report.first_picture},
            {"resumed", report.resumed},
            {"stages", stages},
            {"peak_memory_bytes", peak_memory()}};
}

}  // namespace whorl

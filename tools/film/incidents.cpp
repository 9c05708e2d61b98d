#include "tools/film/incidents.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/models/pressure/crowding.h"

namespace whorl {

bool Incidents::add(Incident incident) {
    if (std::any_of(first_.begin(), first_.end(), [&](const Incident& i) { return i.kind == incident.kind; })) return false;
    first_.push_back(std::move(incident));
    return true;
}

std::string Incidents::add(const StepReport& report, const Scene& scene, double time, long step) {
    std::string unsolved;
    for (const StepReport::Solve& solve : report.solves)
        if (const SolveReport& r = solve.report; solve.name == RelieveCrowding::name) add(Incident{"crowded", time, step, r.why_not});
        else if (!r.converged) {
            const bool viscous = solve.name == "viscosity";
            const bool limited = r.iterations >= (viscous ? scene.viscosity.max_iterations : scene.pressure.max_iterations);
            const std::string what =
                fmt::format("{}: residual {:.2g} (from {:.2g}) after {} iterations{}{}", solve.name, r.last_residual, r.first_residual,
                            r.iterations, r.why_not.empty() ? "" : ", " + r.why_not,
                            limited ? fmt::format("; raise {}.max_iterations", viscous ? "viscosity" : "pressure") : "");
            if (add(Incident{"unconverged", time, step, what})) unsolved = fmt::format("unfinished solve at {:.4g} s: {}", time, what);
        }
    if (!report.full.empty()) add(Incident{"full", time, step, report.full});
    if (report.lost_particles > 0)
        add(Incident{"lost", time, step, fmt::format("{} particles left the domain in one step", report.lost_particles)});
    if (const auto& d = report.diverged)
        add(Incident{"diverged", d->time, step,
                     fmt::format("stage \"{}\", field \"{}\" at ({:.4g}, {:.4g}, {:.4g}) m: {}", d->stage, d->field, d->place.x(),
                                 d->place.y(), d->place.z(), d->what)});
    return unsolved;
}

nlohmann::ordered_json Incidents::json() const {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const Incident& t : first_) all.push_back({{"kind", t.kind}, {"time", t.time}, {"step", t.step}, {"what", t.what}});
    return all;
}

void Incidents::add_earlier(const nlohmann::json& earlier) {
    for (const auto& t : earlier) add(Incident{t.value("kind", ""), t.value("time", 0.0), t.value("step", 0L), t.value("what", "")});
}

}  // namespace whorl

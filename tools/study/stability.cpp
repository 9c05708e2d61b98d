#include "tools/study/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/io/csv.h"

namespace whorl {
namespace {

/// The largest growth of kinetic, potential and spin energy together over what the run began with, as a part of the energy that there was
/// to move: the largest kinetic energy or fall of potential energy on the way.
struct Growth {
    double most = 0;
    const std::vector<double>* first = nullptr;  ///< row that is beyond the allowed part
};
Growth energy_growth(const CsvTable& table, double allowed, double scale) {
    const std::size_t kinetic = table.index("kinetic_energy"), potential = table.index("potential_energy"),
                      spin = table.index("spin_energy");
    const auto value = [](double v) { return std::isfinite(v) ? v : 0; };
    const auto& start = table.rows.front();
    const double e0 = value(start[kinetic]) + value(start[potential]) + value(start[spin]);
    Growth growth;
    double moved = std::max(scale, value(start[kinetic]) + value(start[spin]));
    for (const auto& row : table.rows) {
        moved = std::max(moved, std::abs(value(start[potential]) - value(row[potential])));
        const double more = value(row[kinetic]) + value(row[potential]) + value(row[spin]) - e0;
        growth.most = std::max(growth.most, more > 0 ? more / std::max(moved, 1e-9 * more) : 0);
        if (!growth.first && growth.most > allowed) growth.first = &row;
    }
    return growth;
}

/// What run.json keeps of the first step of a kind of trouble.
Verdict first_trouble(const nlohmann::json& run, const std::string& kind, const std::string& state, const std::string& why) {
    Verdict verdict{state, why, 0, 0};
    for (const auto& trouble : run.value("first_troubles", nlohmann::json::array()))
        if (trouble.value("kind", "") == kind) {
            verdict.time = trouble.value("time", 0.0), verdict.step = trouble.value("step", 0L);
            const std::string what = trouble.value("what", "");
            if (why.find(what) == std::string::npos) verdict.why += (why.empty() ? "" : "; first: ") + what;
        }
    return verdict;
}

}  // namespace

Verdict judge(const StabilityKeys& keys, const PointResult& result) {
    if (result.status == "timeout") return {result.status, result.message, 0, 0};
    std::ifstream in(result.folder / "run.json");
    const nlohmann::json run = nlohmann::json::parse(in, nullptr, false);
    if (result.status == "diverged" && run.is_object()) return first_trouble(run, "diverged", "diverged", result.message);
    if (!result.done() || !run.is_object()) return {"failed", result.message, 0, 0};
    const CsvTable table = read_csv(result.folder / "diagnostics.csv");
    if (table.rows.empty()) return {"failed", "the run left no figures", 0, 0};
    const auto at_row = [&](const std::vector<double>& row, const char* state, std::string why) {
        return Verdict{state, std::move(why), row[table.index("time")], static_cast<long>(row[table.index("steps")])};
    };
    if (const long lost = run.value("lost_particles", 0L); lost > 0)
        return first_trouble(run, "lost", "lost particles",
                             fmt::format("{} of {} left the domain", lost, lost + run.value("particles", 0L)));
    if (keys.energy_growth > 0)
        if (const Growth growth = energy_growth(table, keys.energy_growth, std::strtod(keys.energy_scale.c_str(), nullptr)); growth.first)
            return at_row(*growth.first, "unphysical energy", fmt::format("energy grew by {:.3g} % of what moved", 100 * growth.most));
    const double steps = std::max(1.0, run.value("steps", 1.0));
    if (const double stalled = run.value("unconverged_solves", 0.0) / steps; stalled > keys.stalled)
        return first_trouble(run, "unconverged", "stalled solver",
                             fmt::format("{:.0f} % of the solves ended without convergence", 100 * stalled));
    if (keys.noisy_speed.empty()) return {"stable", "", 0, 0};
    const double allowed = std::strtod(keys.noisy_speed.c_str(), nullptr);
    if (const auto& last = table.rows.back(); last[table.index("max_speed")] > allowed)
        return at_row(last, "noisy",
                      fmt::format("fastest particle {:.3g} m/s at the end, {:.3g} m/s allowed", last[table.index("max_speed")], allowed));
    return {"stable", "", 0, 0};
}

}  // namespace whorl

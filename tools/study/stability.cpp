#include "tools/study/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tools/study/table.h"

namespace whorl {
namespace {

/// The largest growth of kinetic, potential and spin energy together over what the run began with, as a part of the energy that there was to move:
/// the largest kinetic energy or fall of potential energy on the way.
double energy_growth(const CsvTable& table) {
    const std::size_t kinetic = table.index("kinetic_energy"), potential = table.index("potential_energy"), spin = table.index("spin_energy");
    const auto value = [](double v) { return std::isfinite(v) ? v : 0; };
    const auto& first = table.rows.front();
    const double e0 = value(first[kinetic]) + value(first[potential]) + value(first[spin]);
    double growth = 0, moved = value(first[kinetic]) + value(first[spin]);
    for (const auto& row : table.rows) {
        moved = std::max(moved, std::abs(value(first[potential]) - value(row[potential])));
        growth = std::max(growth, value(row[kinetic]) + value(row[potential]) + value(row[spin]) - e0);
    }
    return moved > 0 ? growth / moved : growth > 0 ? 1e9 : 0;
}

}  // namespace

Verdict judge(const StabilityKeys& keys, const PointResult& result) {
    if (result.status == "timeout" || result.status == "diverged") return {result.status, result.message};
    if (!result.done()) return {"failed", result.message};
    const CsvTable table = read_csv(result.folder / "diagnostics.csv");
    std::ifstream in(result.folder / "run.json");
    const nlohmann::json run = nlohmann::json::parse(in, nullptr, false);
    if (table.rows.empty() || !run.is_object()) return {"failed", "the run left no figures"};
    if (const long lost = run.value("lost_particles", 0L); lost > 0)
        return {"lost particles", fmt::format("{} of {} left the domain", lost, lost + run.value("particles", 0L))};
    if (keys.energy_growth > 0)
        if (const double growth = energy_growth(table); growth > keys.energy_growth)
            return {"unphysical energy", fmt::format("energy grew by {:.3g} % of what moved", 100 * growth)};
    const double steps = std::max(1.0, run.value("steps", 1.0));
    if (const double stalled = run.value("unconverged_solves", 0.0) / steps; stalled > keys.stalled)
        return {"stalled solver", fmt::format("{:.0f} % of the solves ended without convergence", 100 * stalled)};
    if (const double speed = table.rows.back()[table.index("max_speed")]; keys.noisy_speed > 0 && speed > keys.noisy_speed)
        return {"noisy", fmt::format("fastest particle {:.3g} m/s at the end", speed)};
    return {"stable", ""};
}

}  // namespace whorl

#include "engine/probes/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/probes/gauge_probe.h"
#include "engine/scene/tree.h"

namespace whorl {

double Comparison::at(const std::string& column, double along_value) const {
    const std::size_t value = table.index(column);
    const std::vector<double>* before = nullptr;
    for (const std::vector<double>& row : table.rows) {
        if (std::isnan(row[value])) continue;
        if (row[along] == along_value) return row[value];
        if (row[along] > along_value) {
            if (!before) break;
            const double part = (along_value - (*before)[along]) / (row[along] - (*before)[along]);
            return (*before)[value] + part * (row[value] - (*before)[value]);
        }
        before = &row;
    }
    return std::numeric_limits<double>::quiet_NaN();
}

std::optional<Comparison> comparison_of(const Scene& scene, std::size_t probe, const Probe& columns_of) {
    const std::filesystem::path& file = scene.probes[probe].compare;
    if (file.empty()) return std::nullopt;
    Comparison found{read_csv(file), file.stem().string()};
    const ProbeColumns columns = columns_of.columns();
    const std::string& along = columns[columns_of.along()].name;
    std::string names;
    bool any = false;
    for (const ProbeColumn& column : columns) {
        if (column.plot.empty()) continue;
        names += (names.empty() ? "" : ", ") + column.name;
        any = any || found.has(column.name);
    }
    const std::string key = entry_name("probe", probe) + ".compare";
    const auto refuse = [&](const std::string& why) {
        throw InputError(scene.place(key), key + ": \"" + file.string() + "\" " + why,
                         "give the table a header line, with cells between commas",
                         "the column " + along + ", and one or more of " + names);
    };
    if (!found.has(along)) refuse("has no column \"" + along + "\"");
    if (!any) refuse("has no column that the probe measures");
    found.along = found.table.index(along);
    std::erase_if(found.table.rows, [&](const std::vector<double>& row) { return std::isnan(row[found.along]); });
    if (found.table.rows.empty()) refuse("has no row with a number for " + along);
    std::stable_sort(found.table.rows.begin(), found.table.rows.end(),
                     [&](const auto& a, const auto& b) { return a[found.along] < b[found.along]; });
    return found;
}

void check_probes(const Simulation& simulation) {
    const Scene& scene = simulation.scene();
    std::vector<Problem> problems;
    for (std::size_t k = 0; k < scene.probes.size(); ++k) try {
            const ProbeKeys& keys = scene.probes[k];
            if (keys.compare.empty() && keys.kind != ProbeKind::gauge) continue;
            const auto probe = make_probe(keys, simulation.world(), TheorySearch::in_background);
            comparison_of(scene, k, *probe);
            if (const auto* gauge = dynamic_cast<const GaugeProbe*>(probe.get()); gauge && !(gauge->area() > 0)) {
                const Solid& solid = simulation.world().solids.all[static_cast<std::size_t>(keys.solid)];
                const std::string key = entry_name("probe", k) + ".at";
                throw InputError(scene.place(key),
                                 fmt::format("{} is {:.4g} m from the surface of {}, out of the gauge's reach", key,
                                             std::abs(solid.distance(keys.at.cast<Real>())), entry_name("solid", keys.solid)),
                                 "put it on the surface, or take a larger radius");
            }
        } catch (const InputError& error) { problems.insert(problems.end(), error.problems().begin(), error.problems().end()); }
    if (!problems.empty()) throw InputError(std::move(problems));
}

}  // namespace whorl

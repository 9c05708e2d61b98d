#include "engine/probes/comparison.h"

#include <algorithm>
#include <cmath>

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
    return unknown;
}

std::optional<Comparison> comparison_of(const Scene& scene, std::size_t probe, const Probe& columns_of) {
    const std::filesystem::path& file = scene.probes[probe].compare;
    if (file.empty()) return std::nullopt;
    Comparison found{read_csv(file), file.stem().string()};
    const ProbeColumns columns = columns_of.columns();
    const std::string& along = columns[columns_of.along()].name;
    std::string names;
    bool any = false;
    for (const ProbePlot& plot : plots_of(columns))
        for (const ProbePlot::Curve& curve : plot.curves) {
            names += (names.empty() ? "" : ", ") + columns[curve.column].name;
            any = any || found.has(columns[curve.column].name);
        }
    const bool has_along = found.has(along);
    if (has_along) {
        found.along = found.table.index(along);
        std::erase_if(found.table.rows, [&](const auto& row) { return std::isnan(row[found.along]); });
        std::stable_sort(found.table.rows.begin(), found.table.rows.end(),
                         [&](const auto& a, const auto& b) { return a[found.along] < b[found.along]; });
    }
    const std::string key = entry_name("probe", probe) + ".compare";
    const std::string lacks = !has_along                 ? "column \"" + along + "\""
                              : !any                     ? "column that the probe measures"
                              : found.table.rows.empty() ? "row with a number for " + along
                                                         : "";
    if (lacks.empty()) return found;
    throw InputError(scene.place(key), key + ": \"" + file.string() + "\" has no " + lacks,
                     "give the table a header line, and separate the cells by commas",
                     "the column " + along + ", and one or more of " + names);
}

void check_probes(const Simulation& simulation) {
    const Scene& scene = simulation.scene();
    std::vector<Problem> problems;
    for (std::size_t k = 0; k < scene.probes.size(); ++k) try {
            if (scene.probes[k].compare.empty() && scene.probes[k].kind != ProbeKind::gauge) continue;  // such a probe has no fault
            const auto probe = make_probe(scene.probes[k], simulation.world(), TheorySearch::in_background);
            if (const std::string fault = probe->fault(); !fault.empty())
                problems.push_back({scene.place(entry_name("probe", k) + ".at"), entry_name("probe", k) + ": " + fault, "", ""});
            comparison_of(scene, k, *probe);
        } catch (const InputError& error) { problems.insert(problems.end(), error.problems().begin(), error.problems().end()); }
    if (!problems.empty()) throw InputError(std::move(problems));
}

}  // namespace whorl

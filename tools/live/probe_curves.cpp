#include <nlohmann/json.hpp>

#include "render/look/overlay.h"
#include "tools/live/live_loop.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

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

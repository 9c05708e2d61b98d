#include "engine/probes/probe_columns.h"

#include <algorithm>

#include "engine/io/csv.h"

namespace whorl {
namespace {

constexpr const char* theory = "theory_";

bool has(const ProbeColumns& columns, const std::string& name) {
    return std::any_of(columns.begin(), columns.end(), [&](const ProbeColumn& c) { return c.name == name; });
}

std::string label_of(const ProbeColumn& column, const ProbeColumns& all) {
    if (column.name.rfind(theory, 0) == 0) return "theory";
    if (has(all, theory + column.name)) return "measured";
    const std::string stem = column.plot + "_";
    return column.name.rfind(stem, 0) == 0 ? column.name.substr(stem.size()) : column.name;
}

}  // namespace

ProbeColumns vector_columns(const std::string& name, const std::string& unit) {
    return {{name + "_x", unit, name}, {name + "_y", unit, name}, {name + "_z", unit, name}};
}

ProbeColumns operator+(ProbeColumns a, const ProbeColumns& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

std::vector<ProbePlot> plots_of(const ProbeColumns& columns) {
    std::vector<ProbePlot> plots;
    for (std::size_t k = 0; k < columns.size(); ++k) {
        const ProbeColumn& c = columns[k];
        if (c.plot.empty()) continue;
        auto plot = std::find_if(plots.begin(), plots.end(), [&](const ProbePlot& p) { return p.title == c.plot; });
        if (plot == plots.end()) plot = plots.insert(plots.end(), {c.plot, c.unit, {}});
        plot->curves.push_back({k, label_of(c, columns), c.name.rfind(theory, 0) == 0 || c.name.rfind("expected_", 0) == 0});
    }
    return plots;
}

std::string csv_header(const ProbeColumns& columns) {
    std::vector<std::string> names;
    for (const ProbeColumn& column : columns) names.push_back(column.name);
    return csv_header(names);
}

}  // namespace whorl

#include "tools/film/probe_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/io/csv.h"
#include "tools/film/curves.h"

namespace whorl {
namespace {

using Rows = std::vector<std::vector<double>>;

/// Rows of the table; if each frame has several, those of five frames, evenly spaced, by frames.
std::vector<Rows> frames_of(const std::filesystem::path& table, bool several) {
    if (!several) return {read_csv(table).rows};
    constexpr std::size_t most = 5;
    std::vector<double> times;
    read_csv(table, [&](const auto& row) {
        if (times.empty() || times.back() != row[0]) times.push_back(row[0]);
    });
    std::map<double, Rows> frames;
    for (std::size_t k = 0; k < most && !times.empty(); ++k) frames[times[k * (times.size() - 1) / (most - 1)]];
    read_csv(table, [&](const auto& row) {
        if (const auto found = frames.find(row[0]); found != frames.end()) found->second.push_back(row);
    });
    std::vector<Rows> all;
    for (auto& [time, rows] : frames) all.push_back(std::move(rows));
    return all;
}

Curve curve_of(const std::string& label, const Rows& rows, std::size_t x, std::size_t y) {
    Curve curve;
    curve.label = label;
    for (const std::vector<double>& row : rows) curve.x.push_back(row[x]), curve.y.push_back(row[y]);
    return curve;
}

/// A component that is 0 throughout, or a value that is never known, is left out beside others.
bool shows(const Curve& curve, bool others) {
    return std::any_of(curve.y.begin(), curve.y.end(), [&](double v) { return std::isfinite(v) && (v != 0 || !others); });
}

}  // namespace

Canvas plot_of_table(const std::string& title, const Probe& probe, const std::filesystem::path& table,
                     const std::optional<Comparison>& comparison) {
    const ProbeColumns columns = probe.columns();
    const std::size_t along = probe.along();
    const std::vector<Rows> frames = frames_of(table, along != 0);
    std::vector<CurvePlot> plots;
    for (const ProbePlot& one : plots_of(columns)) {
        CurvePlot plot{columns[along].name, columns[along].unit, one.title, one.unit, {}};
        for (const ProbePlot::Curve& c : one.curves)
            for (std::size_t n = 0; n < frames.size(); ++n) {
                const bool labelled = along != 0;
                Curve curve = curve_of(labelled ? fmt::format("t = {:.4g} s", frames[n][0][0]) : c.label, frames[n], along, c.column);
                if (!shows(curve, one.curves.size() > 1)) continue;
                curve.style = c.theory ? Curve::Style::dashed : Curve::Style::line;
                curve.colour = plot.curves.size();
                plot.curves.push_back(std::move(curve));
            }
        for (const ProbePlot::Curve& c : one.curves) {
            if (!comparison || !comparison->has(columns[c.column].name)) continue;
            const std::string label = comparison->name + (one.curves.size() > 1 ? ", " + c.label : "");
            Curve curve = curve_of(label, comparison->table.rows, comparison->along, comparison->table.index(columns[c.column].name));
            curve.style = curve.x.size() <= 200 ? Curve::Style::dots : Curve::Style::dashed;
            curve.colour = plot.curves.size();
            plot.curves.push_back(std::move(curve));
        }
        plots.push_back(std::move(plot));
    }
    // Diagrams of what this scene does not have, such as a spin, are left out.
    const auto empty = [](const CurvePlot& plot) { return plot.curves.empty(); };
    if (!std::all_of(plots.begin(), plots.end(), empty)) std::erase_if(plots, empty);
    return draw_plots(title, plots);
}

}  // namespace whorl

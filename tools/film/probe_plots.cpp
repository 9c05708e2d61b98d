#include "tools/film/probe_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/io/csv.h"
#include "tools/film/curves.h"

namespace whorl {
namespace {

using Rows = std::vector<std::vector<double>>;

/// Rows of the table, by frames if each has several: then those of four frames or more, evenly spaced, and of the last.
std::vector<Rows> frames_of(const std::filesystem::path& table, bool several) {
    constexpr std::size_t most = 5;
    std::vector<Rows> frames(1);
    std::size_t count = 0, stride = 1;
    read_csv(table, [&](const std::vector<double>& row) {
        if (several && (count == 0 || row[0] != frames.back().back()[0])) {
            if (count > 0 && (count - 1) % stride != 0) frames.pop_back();
            if (frames.size() == most) {
                stride *= 2;
                for (std::size_t k = 1; k < frames.size(); ++k) frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(k));
            }
            if (count++ > 0) frames.emplace_back();
        }
        frames.back().push_back(row);
    });
    return frames;
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
                const bool labelled = along != 0 && !frames[n].empty();
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

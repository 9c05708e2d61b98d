#include "tools/film/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/core/atomic_file.h"
#include "engine/io/diagnostics.h"
#include "tools/film/curves.h"

namespace whorl {
namespace {

using Rows = std::vector<std::vector<double>>;

/// Groups the rows by frame and returns at most five frames, evenly spaced.
std::vector<Rows> some_frames(Rows rows) {
    constexpr std::size_t most = 5;
    std::map<double, Rows> frames;  // by time
    for (std::vector<double>& row : rows) frames[row[0]].push_back(std::move(row));
    std::vector<Rows> all, some;
    for (auto& [time, frame] : frames) all.push_back(std::move(frame));
    const std::size_t count = std::min(most, all.size());
    for (std::size_t k = 0; k < count; ++k) some.push_back(all[k * (all.size() - 1) / std::max<std::size_t>(1, count - 1)]);
    return some;
}

Curve curve_of(const std::string& label, const Rows& rows, std::size_t x, std::size_t y) {
    Curve curve;
    curve.label = label;
    for (const std::vector<double>& row : rows) curve.x.push_back(row[x]), curve.y.push_back(row[y]);
    return curve;
}

/// Whether to draw a curve: it needs a finite value and, if the plot has other curves, one that is not 0.
bool shows(const Curve& curve, bool others) {
    return std::any_of(curve.y.begin(), curve.y.end(), [&](double v) { return std::isfinite(v) && (v != 0 || !others); });
}

/// Plots the table of a probe over time. If the probe measures at several positions per frame, plots it over the position for some of the
/// frames. Theory is dashed; a comparison is dotted, or dashed if it has more than 200 points. @param table file of a run
Canvas plot_of_table(const std::string& title, const Probe& probe, const std::filesystem::path& table,
                     const std::optional<Comparison>& comparison) {
    const ProbeColumns columns = probe.columns();
    const std::size_t along = probe.along();
    Rows rows = read_csv(table).rows;
    const std::vector<Rows> frames = along == 0 ? std::vector<Rows>{rows} : some_frames(std::move(rows));
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
    // Plots without curves, such as the spin of a fluid that has none, are left out.
    const auto empty = [](const CurvePlot& plot) { return plot.curves.empty(); };
    if (!std::all_of(plots.begin(), plots.end(), empty)) std::erase_if(plots, empty);
    return draw_plots(title, plots);
}

}  // namespace

RunTables::RunTables(std::filesystem::path folder, const Simulation& simulation, const NamedProbes& probes, bool budgeted,
                     const Checkpoint* from)
    : folder_(std::move(folder)), simulation_(simulation), probes_(probes) {
    open(diagnostics, diagnostics_header(simulation.scene().any_temperature()), from);
    if (simulation.world().solids.any_free()) open(bodies, bodies_header(), from);
    if (budgeted) open(budget, budget_header(), from);
    for (const auto& [name, probe] : probes) {
        if (from)
            if (const auto found = from->probes.find(name); found != from->probes.end()) {
                std::istringstream state(found->second);
                probe->load(state);
            }
        open(table_of(name), csv_header(probe->columns()), from);
        comparisons_.push_back(comparison_of(simulation.scene(), comparisons_.size(), *probe));
    }
}

void RunTables::open(const std::string& name, const std::string& header, const Checkpoint* from) {
    if (from)
        if (const auto found = from->table_bytes.find(name); found != from->table_bytes.end()) {
            tables_.emplace(name, Table(folder_ / name, found->second));
            return;
        }
    tables_.emplace(name, Table(folder_ / name, std::string_view(header)));
}

void RunTables::add_frame(int frame, const FrameSummary& summary, double wall, double cpu) {
    const double time = simulation_.time();
    tables_.at(diagnostics).append(diagnostics_row(frame, time, summary.measures, summary.before, simulation_.totals(), wall, cpu));
    if (const auto free = tables_.find(bodies); free != tables_.end())
        free->second.append(bodies_rows(frame, time, simulation_.world(), simulation_.scene().domain.gravity(time)));
    for (const auto& [name, probe] : probes_) tables_.at(table_of(name)).append(csv_lines(rows_of(*probe, simulation_)));
}

void RunTables::draw_plots() const {
    for (std::size_t k = 0; k < probes_.size(); ++k) {
        const auto& [name, probe] = probes_[k];
        const std::string title = simulation_.scene().name + ": " + name;
        const Canvas plot = plot_of_table(title, *probe, folder_ / table_of(name), comparisons_[k]);
        write_text(folder_ / "probes" / (name + ".svg"), plot.svg());
    }
}

void RunTables::save(Checkpoint& state) const {
    for (const auto& [name, table] : tables_) state.table_bytes[name] = table.bytes();
    for (const auto& [name, probe] : probes_) {
        std::ostringstream memory;
        probe->save(memory);
        state.probes[name] = std::move(memory).str();
    }
}

}  // namespace whorl

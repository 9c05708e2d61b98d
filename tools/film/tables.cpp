#include "tools/film/tables.h"

#include <sstream>

#include "engine/core/whole_file.h"
#include "engine/io/bodies.h"
#include "engine/io/csv.h"
#include "engine/io/diagnostics.h"
#include "tools/film/probe_plots.h"

namespace whorl {

RunTables::RunTables(std::filesystem::path folder, const Simulation& simulation, const NamedProbes& probes, bool budgeted,
                     const Checkpoint* from)
    : folder_(std::move(folder)), simulation_(simulation), probes_(probes) {
    open(diagnostics, diagnostics_header(), from);
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

double RunTables::last_given_up() const {
    const auto table = tables_.find(budget);
    if (table == tables_.end()) return 0;
    const CsvTable rows = read_csv(table->second.file());
    return rows.rows.empty() ? 0 : rows.rows.back()[rows.index("given_up")];
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

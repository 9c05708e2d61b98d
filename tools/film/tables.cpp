#include "tools/film/tables.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "engine/io/bodies.h"
#include "tools/film/governor.h"

namespace whorl {

RunTables::RunTables(std::filesystem::path folder, const Simulation& simulation, bool budgeted, const Checkpoint* from)
    : folder_(std::move(folder)), simulation_(simulation) {
    open(diagnostics, diagnostics_header(), from);
    if (simulation.world().solids.any_free()) open(bodies, bodies_header(), from);
    if (budgeted) open(budget, budget_header(), from);
    for (const ProbeKeys& keys : simulation.scene().probes) {
        std::unique_ptr<Probe> probe = make_probe(keys, simulation.world());
        if (from)
            if (const auto found = from->probes.find(keys.name); found != from->probes.end()) {
                std::istringstream state(found->second);
                probe->load(state);
            }
        open(table_of(keys.name), probe->header(), from);
        probes_.emplace(keys.name, std::move(probe));
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

void RunTables::after_step() {
    for (auto& [name, probe] : probes_) probe->after_step(simulation_.world(), simulation_.time());
}

void RunTables::land(int frame, const Measures& measures, const RunTotals& before, double wall, double cpu) {
    const double time = simulation_.time();
    tables_.at(diagnostics).append(diagnostics_row(frame, time, measures, before, simulation_.totals(), wall, cpu));
    if (const auto free = tables_.find(bodies); free != tables_.end())
        free->second.append(bodies_rows(frame, time, simulation_.world(), simulation_.scene().domain.gravity(time)));
    for (auto& [name, probe] : probes_) tables_.at(table_of(name)).append(rows_of(*probe, simulation_));
}

double RunTables::last_given_up() const {
    const auto table = tables_.find(budget);
    if (table == tables_.end()) return 0;
    std::ifstream in(table->second.file());
    std::string line, last;
    while (std::getline(in, line))
        if (!line.empty()) last = line;
    for (int column = 0; column < 4; ++column) last = last.substr(std::min(last.size(), last.find(',') + 1));
    return std::strtod(last.c_str(), nullptr);
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

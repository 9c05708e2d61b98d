#pragma once
/// The tables of a run, some rows a frame: diagnostics.csv, bodies.csv where solids are free, budget.csv where the scene has one,
/// probes/NAME.csv with the probes that fill them.
#include <map>

#include "engine/io/checkpoint.h"
#include "engine/io/diagnostics.h"
#include "engine/io/files.h"
#include "engine/probes/probes.h"

namespace whorl {

class RunTables {
public:
    /// @param budgeted there is a governor, whose table is budget.csv
    /// @param from where the run goes on from: tables are cut back to what they held then, probes remember; null for a new run
    /// @throws EnvironmentError where a table is shorter than it was, or cannot be made
    RunTables(std::filesystem::path folder, const Simulation& simulation, bool budgeted, const Checkpoint* from);
    /// What every step is seen by.
    void after_step();
    /// The rows of a frame. @param before totals at the last row @param wall,cpu s so far
    void land(int frame, const Measures& measures, const RunTotals& before, double wall, double cpu);
    void add_budget(const std::string& row) { tables_.at(budget).append(row); }
    /// What the governor of the run so far had given up, by the budget's last row; 0 where there is none.
    double last_given_up() const;
    /// Lengths of the tables and memories of the probes.
    void save(Checkpoint& state) const;

private:
    static constexpr const char *diagnostics = "diagnostics.csv", *bodies = "bodies.csv", *budget = "budget.csv";
    static std::string table_of(const std::string& probe) { return "probes/" + probe + ".csv"; }
    void open(const std::string& name, const std::string& header, const Checkpoint* from);

    std::filesystem::path folder_;
    const Simulation& simulation_;
    std::map<std::string, Table> tables_;  ///< by their path in the run folder
    std::map<std::string, std::unique_ptr<Probe>> probes_;
};

}  // namespace whorl

#pragma once
/// Tables of a run with rows for each frame: diagnostics.csv, bodies.csv if solids are free, budget.csv if the scene has a budget, and
/// probes/NAME.csv for each probe. Also the plots of the probes.
#include <filesystem>
#include <map>

#include "engine/io/checkpoint.h"
#include "engine/io/csv.h"
#include "engine/probes/comparison.h"
#include "tools/film/frame_loop.h"

namespace whorl {

class RunTables {
public:
    /// @param budgeted also writes budget.csv @param probes must outlive this object
    /// @param from checkpoint to continue from: tables are truncated to it, probes restored; null for a new run
    /// @throws EnvironmentError if a table is shorter than at the checkpoint, or cannot be made; InputError as comparison_of()
    RunTables(std::filesystem::path folder, const Simulation& simulation, const NamedProbes& probes, bool budgeted, const Checkpoint* from);
    /// Adds the rows of a frame. @param wall,cpu times since the start of the run [s]
    void add_frame(int frame, const FrameSummary& summary, double wall, double cpu);
    void add_budget(const std::string& row) { tables_.at(budget).append(row); }
    /// Writes probes/NAME.svg for each probe, from its current table.
    void draw_plots() const;
    /// Stores the lengths of the tables and the states of the probes.
    void save(Checkpoint& state) const;

private:
    static constexpr const char *diagnostics = "diagnostics.csv", *bodies = "bodies.csv", *budget = "budget.csv";
    static std::string table_of(const std::string& probe) { return "probes/" + probe + ".csv"; }
    void open(const std::string& name, const std::string& header, const Checkpoint* from);

    std::filesystem::path folder_;
    const Simulation& simulation_;
    std::map<std::string, Table> tables_;  ///< by their path in the run folder
    const NamedProbes& probes_;
    std::vector<std::optional<Comparison>> comparisons_;  ///< data to compare each probe with, read at the start
};

}  // namespace whorl

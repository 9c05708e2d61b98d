#pragma once
/// Common part of `whorl tradeoff` and `whorl stability`: options, the loop over the points of a study, its table and plot.
#include <functional>
#include <nlohmann/json.hpp>

#include "render/image/canvas.h"
#include "tools/study/point.h"

namespace CLI {
class App;
}

namespace whorl {

struct SweepOptions {
    std::string study;
    std::filesystem::path out;        ///< empty: out/<study name>
    int threads = 0;                  ///< threads of each run; 0: the cores divided by the jobs, on Slurm 1
    int jobs = 0;                     ///< runs at the same time; 0: 1 if runs are timed, otherwise as many as the cores allow, on Slurm 8
    std::string on = "local";         ///< local | slurm
    std::vector<std::string> sbatch;  ///< additional options of sbatch
    std::string budget;               ///< wall time after which no run is started, as in "10min"; empty: no limit
    std::string recommend;            ///< tradeoff: goal of --recommend, as in "error<2%", "fps>24"
    bool all = false;                 ///< tradeoff: run the whole grid
    bool json = false;
};

void add_sweep_options(CLI::App& app, SweepOptions& options);
/// Adds --on and --sbatch.
void add_slurm_options(CLI::App& app, std::string& on, std::vector<std::string>& sbatch);

/// Sweep of one scene of a study.
struct Sweep {
    const Study& study;
    const SweepOptions& options;
    std::string scene;
    std::filesystem::path folder;  ///< folder of the results
    PointRunner runner;

    void say(const std::string& text) const;  ///< prints a line, unless --json is given

    /// Calls PointRunner::run(). A point with invalid settings gets the status "refused".
    PointResult point(const std::vector<std::string>& settings, int repeat, bool pictures) const;

    /// Task that runs in a separate thread. It returns a function that the thread of run() calls with the result.
    using Task = std::function<std::function<void()>()>;
    /// Runs tasks, up to options.jobs at the same time, until none runs and `next` returns none. @param next returns the next task, given
    /// the remaining seconds of the budget; empty: none at present
    void run(const std::function<Task(double)>& next) const;

    /// Writes folder/NAME.csv with the scene, the settings and these columns of the rows, and the plot as .png and .svg. With --json it
    /// prints the complete rows. @param rows_name name of the rows in the JSON @param rows objects; "settings" is a list of "key=value" per
    /// knob
    void write(const std::string& name, const Canvas& canvas, const std::vector<std::string>& columns, const char* rows_name,
               const nlohmann::ordered_json& rows) const;
};

/// Runs a study's scenes one after the other, each in a separate folder. @param timed whether the runs are timed; then, on this machine,
/// one runs at a time by default @return an ExitCode @throws InputError if another process works in the folder
int run_sweeps(const Study& study, SweepOptions options, bool timed, const std::function<void(const Sweep&)>& sweep);

}  // namespace whorl

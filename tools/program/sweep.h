#pragma once
/// Common part of tradeoff and stability: options, the loop over the points of a study, and the table and picture of its rows.
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
    int threads = 0;                  ///< of each run; 0: those that the jobs leave
    int jobs = 0;                     ///< runs at the same time; 0: as many as do not disturb measurements
    std::string on = "local";         ///< local | slurm: where the runs are
    std::vector<std::string> sbatch;  ///< more options of sbatch
    std::string budget;               ///< "10min": stop after that long
    std::string recommend;            ///< tradeoff: "error<2%", "fps>24"
    bool all = false;                 ///< tradeoff: the whole grid
    bool json = false;
};

void add_sweep_options(CLI::App& app, SweepOptions& options);
/// --on and --sbatch.
void add_slurm_options(CLI::App& app, std::string& on, std::vector<std::string>& sbatch);

/// One scene of a study, of which points are run.
struct Sweep {
    const Study& study;
    const SweepOptions& options;
    std::string scene;
    std::filesystem::path folder;  ///< of the results
    PointRunner runner;

    void say(const std::string& text) const;  ///< a line, not with --json

    /// PointRunner::run(); a point that cannot work has the status "refused".
    PointResult point(const std::vector<std::string>& settings, int repeat, bool pictures) const;

    /// Runs in a thread of its own; the function that it returns is called in the caller's.
    using Task = std::function<std::function<void()>()>;
    /// Runs tasks, several at the same time. @param next the next task, given the seconds that are left; empty: none at present
    void run(const std::function<Task(double)>& next) const;

    /// Writes the scene, the settings and these columns of the rows as folder/NAME.csv, and the picture as .png and .svg; with --json
    /// prints all of the rows. @param rows_name in the JSON @param rows objects, "settings" among them: "key=value" of each knob
    void write(const std::string& name, const Canvas& canvas, const std::vector<std::string>& columns, const char* rows_name,
               const nlohmann::ordered_json& rows) const;
};

/// Runs a study's scenes one after the other, each in its folder. @param timed the runs are timed: on this machine they get the cores for
/// themselves @return an ExitCode @throws InputError if another process is at work in the folder
int run_sweeps(const Study& study, SweepOptions options, bool timed, const std::function<void(const Sweep&)>& sweep);

}  // namespace whorl

#pragma once
/// What tradeoff and stability share: settings of a grid point, the folder of a study, words for the terminal.
#include "tools/study/front.h"
#include "tools/study/point.h"

namespace CLI {
class App;
}

namespace whorl {

struct SweepOptions {
    std::string study;
    std::filesystem::path out;        ///< empty: out/<study name>
    int threads = 0;                  ///< of each run; 0: those that the jobs leave
    int jobs = 0;                     ///< runs at the same time; 0: as many as do not disturb what is measured
    std::string on = "local";         ///< local | slurm: where the runs are
    std::vector<std::string> sbatch;  ///< more options of sbatch
    std::string budget;               ///< "10min": stop after that long
    std::string recommend;            ///< tradeoff: "error<2%", "fps>24"
    bool all = false;                 ///< tradeoff: the whole grid
    bool json = false;
};

void add_sweep_options(CLI::App& app, SweepOptions& options);

/// Fills in threads and jobs. @param timed runs are timed: on this machine they get the cores for themselves
void share_cores(SweepOptions& options, bool timed);
PointPlace point_place(const SweepOptions& options);
std::filesystem::path folder_of(const Study& study, const SweepOptions& options);
/// The settings at a point of the grid: "key=value" for each knob.
std::vector<std::string> settings_at(const Study& study, const GridPoint& p);
/// Values as labels: "0.002, 0.01".
std::string label_at(const Study& study, const GridPoint& p);
/// "90", "90s", "10min", "1.5h" in seconds. @throws InputError
double seconds_of(const std::string& budget);

}  // namespace whorl

#pragma once
/// Common part of tradeoff and stability: options and the loop over the points of a study.
#include <algorithm>
#include <chrono>
#include <functional>
#include <future>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "engine/core/clock.h"
#include "render/image/canvas.h"
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
    int jobs = 0;                     ///< runs at the same time; 0: as many as do not disturb measurements
    std::string on = "local";         ///< local | slurm: where the runs are
    std::vector<std::string> sbatch;  ///< more options of sbatch
    std::string budget;               ///< "10min": stop after that long
    std::string recommend;            ///< tradeoff: "error<2%", "fps>24"
    bool all = false;                 ///< tradeoff: the whole grid
    bool json = false;
};

void add_sweep_options(CLI::App& app, SweepOptions& options);

/// One scene of a study, of which points are run.
struct Sweep {
    const Study& study;
    const SweepOptions& options;
    std::string scene;
    std::filesystem::path folder;  ///< of the results
    PointRunner runner;

    Sweep(const Study& study, const SweepOptions& options, std::string scene, std::filesystem::path folder);
    void say(const std::string& text) const;  ///< a line, not with --json
    /// Prints the result as JSON where it is asked for.
    void print_json(const char* points_name, nlohmann::ordered_json points) const;
    /// Writes the table and the picture as folder/NAME.csv, .png and .svg.
    void write(const std::string& name, const std::string& csv, const Canvas& canvas) const;

    /// Runs tasks, several at a time. @param next the next task, which gets the seconds that are left; empty: none
    /// @param done gets the number of a task and its result, in this thread
    template <class Result>
    void run(const std::function<std::function<Result()>(double)>& next, const std::function<void(std::size_t, Result)>& done) const {
        const double began = wall_seconds(), budget = seconds_of(options.budget);
        const auto left = [&] { return budget > 0 ? budget - (wall_seconds() - began) : std::numeric_limits<double>::infinity(); };
        std::vector<std::pair<std::size_t, std::future<Result>>> running;
        for (std::size_t started = 0;;) {
            const bool room = running.size() < static_cast<std::size_t>(options.jobs) && left() > 0;
            if (const std::function<Result()> task = room ? next(left()) : nullptr) {
                running.emplace_back(started++, std::async(std::launch::async, task));
                continue;
            }
            if (running.empty()) return;
            const auto ended = std::find_if(running.begin(), running.end(), [](const auto& job) {
                return job.second.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
            });
            if (ended == running.end()) {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
                continue;
            }
            auto [k, result] = std::move(*ended);
            running.erase(ended);
            done(k, result.get());
        }
    }
};

/// Runs a study's scenes one after the other, each in its folder. @param timed the runs are timed: on this machine they get the cores for
/// themselves @return an ExitCode @throws InputError if another process is at work in the folder
int run_sweeps(const Study& study, SweepOptions options, bool timed, const std::function<void(const Sweep&)>& sweep);

/// @return an ExitCode @throws InputError if the study cannot be run so
int run_tradeoff(const SweepOptions& options);
int run_stability(const SweepOptions& options);

}  // namespace whorl

#pragma once
/// One point of a study: a run in a separate process, whose result later calls reuse.
#include <filesystem>
#include <string>
#include <vector>

#include "tools/process/process.h"
#include "tools/scene_file/options.h"
#include "tools/study/study.h"

namespace whorl {

struct PointResult {
    std::string status;             ///< done | diverged | failed, as in run.json; or timeout
    std::string message;            ///< reason if the status is not done
    std::vector<double> cpu, wall;  ///< s, one per timing
    double memory = 0;              ///< peak, bytes
    double frames = 0;
    double limit = 0;              ///< allowed wall time, s
    std::string made_by;           ///< call, checksum of its input and build of the program, as text
    bool kept = false;             ///< whether an earlier call of the study made the result
    std::filesystem::path folder;  ///< run folder
    bool done() const { return status == "done"; }
    double fps() const { return wall.empty() ? 0 : frames / wall.front(); }
};

/// Thrown if SIGINT or SIGTERM ended a point. Finished points are kept, and the next call continues the study.
struct StudyInterrupted {};

/// Settings and command of a point.
struct PointCall {
    std::string name;                   ///< the knobs' settings, joined
    std::vector<std::string> settings;  ///< result of run_settings()
    Options options;                    ///< scene, quality and keys
    std::string program, threads;       ///< if empty: this program; the threads of the PointRunner
};
/// @param settings "key=value" of each knob, in addition to the study's own
PointCall point_call(const Study& study, const std::string& scene, const std::vector<std::string>& settings);

/// Runs points. Several threads may run different points at the same time.
struct PointRunner {
    const Study& study;
    std::filesystem::path folder;  ///< of the study's results; runs are written below its folder "points"
    int threads = 1;               ///< per run
    bool slurm = false;            ///< whether each point is a Slurm job, which Slurm restarts if its machine fails; else it runs locally
    std::vector<std::string> sbatch;  ///< additional options of sbatch

    /// @param settings "key=value" of each knob @param repeat number of timings @param pictures whether to draw images
    /// @throws InputError if the scene or a setting is invalid, EnvironmentError if this program's file was removed, StudyInterrupted
    PointResult run(const std::string& scene, const std::vector<std::string>& settings, int repeat, bool pictures) const;

    InterruptGuard interrupt = {};
    std::filesystem::file_time_type began = std::filesystem::file_time_type::clock::now();
};

/// Writes the script that all Slurm jobs of a study use. Call it before the first job. @param folder of the study's results
void prepare_jobs(const std::filesystem::path& folder);

/// "fluid.spacing=0.002, pressure.tolerance=0.01"
std::string joined_settings(const std::vector<std::string>& settings);

/// Relative error of the run in `folder` (0.01: one per cent). For an accuracy of kind picture: mean CIE76 difference of the last images.
/// NaN if the table has no row from accuracy.from on. @param reference folder of the reference run; empty if the kind needs none
double error_of(const AccuracyKeys& accuracy, const std::filesystem::path& folder, const std::filesystem::path& reference);

struct Verdict {
    std::string state;  ///< stable | noisy | diverged | lost particles | stalled solver | unphysical energy | timeout | refused | failed
    std::string why;    ///< the value that decided, and the first bad step's report if there is one
    double time = 0;    ///< s, of the first bad step, or of the first bad frame if no single step is to blame
    long step = 0;      ///< number of that step; 0: none
    bool stable() const { return state == "stable"; }
};

/// Judges a run by its run.json and diagnostics.csv. If several states apply, the worst is returned.
Verdict judge(const StabilityKeys& keys, const PointResult& result);

}  // namespace whorl

#pragma once
/// One point of a study: a run in a separate process, kept when it is done.
#include <filesystem>
#include <string>
#include <vector>

#include "tools/process/process.h"
#include "tools/scene_file/options.h"
#include "tools/study/study.h"

namespace whorl {

struct PointResult {
    std::string status;             ///< of run.json: done | diverged | failed; or "timeout"
    std::string message;            ///< reason if it is not done
    std::vector<double> cpu, wall;  ///< s, one for each timing
    double memory = 0;              ///< bytes, peak
    double frames = 0;
    double limit = 0;              ///< s of wall time that it was given
    std::string made_by;           ///< the call, the checksum of its input and the program's build
    bool kept = false;             ///< an earlier call of the study made it
    std::filesystem::path folder;  ///< of the run
    bool done() const { return status == "done"; }
    double fps() const { return wall.empty() ? 0 : frames / wall.front(); }
};

/// Thrown if SIGINT or SIGTERM ended a point: finished points are kept, and the next call continues the study.
struct StudyInterrupted {};

/// The command of a point.
struct PointCall {
    std::string name;                   ///< settings of the knobs
    std::vector<std::string> settings;  ///< of run_settings()
    Options options;                    ///< scene, quality and keys
    std::string program, threads;       ///< empty: this program, the study's threads
};
/// @param settings "key=value" of each knob, on top of the study's own
PointCall point_call(const Study& study, const std::string& scene, const std::vector<std::string>& settings);

/// Runs points; different points from several threads at the same time if need be.
struct PointRunner {
    const Study& study;
    std::filesystem::path folder;     ///< of the study's results; points go into its folder "points"
    int threads = 1;                  ///< of each run
    bool slurm = false;               ///< each as a job of Slurm's, which restarts it if its machine fails; else on this machine
    std::vector<std::string> sbatch;  ///< more options of sbatch

    /// @param settings "key=value" of each knob @param repeat timings @param pictures draw
    /// @throws InputError if the scene or a setting cannot work, EnvironmentError if this program's file was removed, StudyInterrupted
    PointResult run(const std::string& scene, const std::vector<std::string>& settings, int repeat, bool pictures) const;

    InterruptGuard interrupt = {};
    std::filesystem::file_time_type began = std::filesystem::file_time_type::clock::now();
};

/// Writes the script of all points that run as jobs of Slurm's; before the first of them. @param folder of the study's results
void prepare_jobs(const std::filesystem::path& folder);

/// "fluid.spacing=0.002, pressure.tolerance=0.01"
std::string joined_settings(const std::vector<std::string>& settings);

/// The relative error of the run in `folder` (0.01: one per cent); of kind picture: the mean CIE76 difference of the last picture.
/// NaN if the run has no row that counts. @param reference folder of the run that counts as true; empty if none is needed
double error_of(const AccuracyKeys& accuracy, const std::filesystem::path& folder, const std::filesystem::path& reference);

struct Verdict {
    std::string state;  ///< stable | noisy | diverged | lost particles | stalled solver | unphysical energy | timeout | refused | failed
    std::string why;    ///< the number that decided; the report of the first bad step if there is one
    double time = 0;    ///< s, of the first bad step (or of the first frame that shows what no single step does)
    long step = 0;      ///< its number; 0: none
    bool stable() const { return state == "stable"; }
};

/// Judges a run by its run.json and diagnostics.csv, the worst finding first.
Verdict judge(const StabilityKeys& keys, const PointResult& result);

}  // namespace whorl

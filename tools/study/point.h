#pragma once
/// One point of a study: a run in a separate process, kept when it is done.
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "tools/process/process.h"
#include "tools/scene_file/options.h"
#include "tools/study/study.h"

namespace whorl {

struct PointResult {
    std::string status;  ///< of run.json: done | diverged | failed; or "timeout"
    std::string message;
    std::vector<double> cpu, wall;  ///< s, one for each timing
    double memory = 0;              ///< bytes, peak
    double frames = 0;
    bool kept = false;             ///< it was there before the call
    std::filesystem::path folder;  ///< of the run
    bool done() const { return status == "done"; }
    double fps() const { return frames / wall.front(); }
};

/// Folder and machine of points.
struct PointPlace {
    bool slurm = false;  ///< each as a job of Slurm's, which finds it a machine and begins it again where that one fails; else here
    std::vector<std::string> sbatch;  ///< more options of sbatch
};

/// Thrown if SIGINT or SIGTERM ended a point: finished points are kept, and the next call continues the study.
struct StudyInterrupted {};

/// Runs points, from several threads at a time if need be.
class PointRunner {
public:
    /// @param folder of the study's results; points go into its folder "points" @param threads of each run; 0: all cores
    PointRunner(const Study& study, std::filesystem::path folder, int threads, PointPlace place = {});

    /// @param settings on top of the study's own @param repeat timings @param pictures draw
    /// @throws InputError if the scene or a setting cannot work, EnvironmentError if this program's file was removed, StudyInterrupted
    PointResult run(const std::string& scene, const std::vector<std::string>& settings, int repeat, bool pictures) const;

private:
    struct Call;
    static Call call_of(const Study& study, int threads, const std::string& scene, std::vector<std::string> settings);
    static std::string identity_of(const Call& call, bool pictures);
    static std::vector<std::string> arguments_of(const Call& call, bool pictures, const std::filesystem::path& folder);
    int run_job(const Call& call, const std::vector<std::string>& arguments, const std::filesystem::path& output) const;
    void run_once(const Call& call, bool pictures, const std::string& words, PointResult& result) const;

    const Study& study_;
    std::filesystem::path folder_;
    int threads_;
    PointPlace place_;
    InterruptGuard interrupt_;
    mutable std::mutex mutex_;                                     ///< of what follows
    mutable std::map<std::filesystem::path, std::mutex> folders_;  ///< of points: one call at a time
    mutable std::set<std::filesystem::path> ran_;                  ///< of those that it ran
};

/// The scene that a point reads, as the command line gives it. @param settings of run_settings()
Options point_options(const Study& study, const std::string& scene, const std::vector<std::string>& settings);

/// Whether settings name a program of their own, which takes and refuses scenes as it can.
bool name_a_program(const std::vector<std::string>& settings);

/// "fluid.spacing=0.002, pressure.tolerance=0.01"
std::string joined_settings(const std::vector<std::string>& settings);

/// The relative error of the run in `folder` (0.01: one per cent); of kind picture: the mean CIE76 difference of the last picture.
/// NaN if the run has no row that counts. @param reference folder of the run that counts as true; empty if none is needed
double error_of(const AccuracyKeys& accuracy, const std::filesystem::path& folder, const std::filesystem::path& reference);

struct Verdict {
    std::string state;  ///< stable | noisy | diverged | lost particles | stalled solver | unphysical energy | timeout | failed
    std::string why;    ///< the number that decided; the report of the first bad step if there is one
    double time = 0;    ///< s, of the first bad step (or of the first frame that shows what no single step does)
    long step = 0;      ///< its number; 0: none
    bool stable() const { return state == "stable"; }
};

/// Judges a run by its run.json and diagnostics.csv, the worst finding first.
Verdict judge(const StabilityKeys& keys, const PointResult& result);

}  // namespace whorl

#pragma once
/// Work in stages: tasks that need nothing of each other, one stage after the other, on this machine or on Slurm's.
///
/// Each stage is a script in the farm's folder, which takes the number of a task: `bash simulate.sh 3`. It leaves simulate.3.log and, when
/// the task has ended, its exit status in simulate.3.code. Slurm runs the same script as a job array; a task that lost its machine is begun
/// again and goes on from its checkpoint.
#include <filesystem>
#include <string>
#include <vector>

#include "tools/process/interrupt.h"

namespace whorl {

struct FarmTask {
    std::string name;                  ///< in messages
    std::vector<std::string> command;  ///< the program and its words
    std::filesystem::path begun;       ///< where this exists the task was begun before, and `go_on` is run; empty: never
    std::vector<std::string> go_on;
};

struct FarmStage {
    std::string name;  ///< of its files: letters and digits
    std::vector<FarmTask> tasks;
    double seconds = 0;  ///< wall time that one task may take; 0: not known
    double bytes = 0;    ///< memory of one task; 0: not known
};

struct FarmOptions {
    std::string on = "local";         ///< local | slurm
    int jobs = 0;                     ///< tasks at the same time; 0: local: as many as the cores carry, slurm: no limit
    int threads = 0;                  ///< of each task; 0: local: what the tasks leave each, slurm: 1
    std::vector<std::string> sbatch;  ///< more options of sbatch: "--partition=short"
    bool quiet = false;
};

/// @throws InputError where `on` is unknown, or options of sbatch go to this machine; EnvironmentError where Slurm is not there
void check_farm(const FarmOptions& options);
/// Fills in jobs and threads. @param tasks of the largest stage
void share_cores(FarmOptions& options, std::size_t tasks);

/// Runs them in `folder`, which is made, and follows them in one line on standard error.
/// @return false where the user interrupted: tasks on this machine are ended then, and Slurm's go on
/// @throws EnvironmentError where a task failed, with the last lines that it wrote
bool run_stages(const std::vector<FarmStage>& stages, const std::filesystem::path& folder, const FarmOptions& options,
                const InterruptGuard& interrupt);

}  // namespace whorl

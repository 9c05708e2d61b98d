#pragma once
/// Work in stages: tasks that need nothing of each other, one stage after the other, on this machine or on Slurm's.
///
/// Each stage is a script in the farm's folder, which takes the number of a task: `bash simulate.sh 3`. It leaves simulate.3.log and, when
/// the task has ended, its exit status in simulate.3.code (-1: it was not begun). Slurm runs the same script as a job array; a task
/// that lost its machine is begun again and goes on from its checkpoint.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tools/process/process.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

struct FarmTask {
    std::string name;                  ///< in messages
    std::vector<std::string> command;  ///< the program and its words
    /// Of the film that it is for. It needs the tasks of earlier stages that are for the same film: unless these have ended well it is left
    /// out.
    std::filesystem::path film;
    std::filesystem::path run;  ///< folder of the run that it makes; where a checkpoint stands there, `go_on` is run; empty: none
    std::vector<std::string> go_on;
    bool takes_diverged = false;  ///< a run that it needs may have diverged, too
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

struct FarmFailure {
    std::filesystem::path film;
    std::string message;  ///< which task, and the last lines that it wrote
};
struct FarmEnd {
    bool interrupted = false;  ///< by the user: tasks on this machine are ended then, and Slurm's go on
    /// Of films that were interrupted on this machine: the first stage that has not ended.
    std::map<std::filesystem::path, std::string> stopped;
    std::vector<FarmFailure> failures;
};

/// Runs them in `folder`, which is made, and follows them in one line on standard error. The numbers of Slurm's jobs stand in jobs.txt
/// there, and in the folder farm of each film. @throws EnvironmentError where Slurm takes no jobs
FarmEnd run_stages(const std::vector<FarmStage>& stages, const std::filesystem::path& folder, const FarmOptions& options,
                   const InterruptGuard& interrupt);

struct FarmFilm {
    SceneFile file;
    std::filesystem::path folder;  ///< of the run
    int pieces = 0;                ///< of a film that is drawn in pieces; 0: eight, and none shorter than ten frames
    int threads = 1;               ///< of each task
};

/// Files that a film's tasks read, and their content.
using FarmFiles = std::vector<std::pair<std::filesystem::path, std::string>>;

/// Adds the film's tasks. A film of panels: `panels` (a run each) and `gather`. Any other: `simulate`, `draw` (a range of frames each) and
/// `encode`; without images `simulate` alone. Writes nothing. @throws InputError if the scene is impossible
FarmFiles add_film(const FarmFilm& film, std::vector<FarmStage>& stages);

/// The commands that complete a film of which this stage was interrupted on this machine.
std::string remaining_commands(const FarmFilm& film, const std::string& stage);

}  // namespace whorl

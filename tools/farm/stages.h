#pragma once
/// A film as a sequence of stages, each a set of independent tasks. A stage begins when the previous one has ended. On Slurm a stage is a
/// job array; on this machine the tasks run in sequence.
///
/// Each stage is a script in the subfolder `farm` of the run folder. Its argument is the number of a task: `bash simulate.sh 3`. It writes
/// simulate.3.log and, when the task has ended, the exit status to simulate.3.code. If the machine of a task fails, Slurm starts the task
/// again, and it continues from its checkpoint.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tools/process/process.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

struct FarmTask {
    std::string name;                  ///< of the task in messages
    std::vector<std::string> command;  ///< the program and its arguments
    std::filesystem::path run;         ///< folder of the run that the task makes; empty: none
    std::vector<std::string> resume;   ///< replaces `command` if `run` contains a checkpoint
};

struct FarmStage {
    std::string name;  ///< begins the names of its files; letters and digits
    std::vector<FarmTask> tasks;
    double seconds = 0;           ///< limit of the wall time of one task
    double bytes = 0;             ///< limit of the memory of one task
    bool after_failures = false;  ///< begins even if a task of the previous stage failed
};

struct FarmFilm {
    SceneFile file;
    std::filesystem::path folder;  ///< run folder, absolute path
    std::vector<FarmStage> stages;
    std::vector<std::pair<std::filesystem::path, std::string>> files;  ///< files that the tasks read: path, content
};

struct FarmOptions {
    std::string on = "local";         ///< local | slurm
    int jobs = 0;                     ///< slurm: limit of tasks of a stage that run at the same time; 0: none
    int threads = 0;                  ///< per task; the caller sets at least 1
    int pieces = 0;                   ///< ranges of frames to draw as separate tasks; 0: at most eight, of at least ten frames
    std::vector<std::string> sbatch;  ///< additional options of sbatch: "--partition=short"
    bool quiet = false;
};

/// Checks the options. @throws InputError if `on` is unknown or an option has no effect there; EnvironmentError if Slurm is not installed
void check_farm(const FarmOptions& options);

/// Stages of a film and the files that its tasks read. With panels: `panels` (one task per run) and `gather`. Otherwise: `simulate`, `draw`
/// (one task per range of frames) and `encode`; without images only `simulate`. Writes nothing. @throws InputError if the scene is
/// impossible
FarmFilm farm_film(const SceneFile& file, const std::filesystem::path& folder, const FarmOptions& options);

struct FarmEnd {
    std::vector<std::string> failures;  ///< one line per failed task, with the end of its log
    std::string stopped;                ///< stage that was interrupted on this machine; "" if none
};

/// Makes the films and prints the progress on standard error. On this machine they are made in sequence. On Slurm all are submitted at
/// once, and the job numbers of each are written to its farm/jobs.txt. @return the result of each film; empty if it was interrupted while
/// it waited for Slurm @throws EnvironmentError if Slurm accepts no jobs
std::vector<FarmEnd> make_films(const std::vector<FarmFilm>& films, const FarmOptions& options, const InterruptGuard& interrupt);

/// Commands that complete a film after `stage` was interrupted on this machine.
std::string remaining_commands(const SceneFile& file, const std::filesystem::path& folder, const std::string& stage);

}  // namespace whorl

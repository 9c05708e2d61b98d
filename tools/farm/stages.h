#pragma once
/// A film as stages of tasks: the tasks of a stage are independent, a stage begins when the one before it has ended. On Slurm a stage is a
/// job array; on this machine the tasks run one after the other.
///
/// Each stage is a script in the folder `farm` of the run, which takes the number of a task: `bash simulate.sh 3`. It leaves simulate.3.log
/// and, when the task has ended, its exit status in simulate.3.code. A task that lost its machine is begun again by Slurm and continues
/// from its checkpoint.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tools/process/process.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

struct FarmTask {
    std::string name;                  ///< in messages
    std::vector<std::string> command;  ///< the program and its arguments
    std::filesystem::path run;         ///< folder of the run that it makes; if it holds a checkpoint, `resume` is run; empty: none
    std::vector<std::string> resume;
};

struct FarmStage {
    std::string name;  ///< of its files: letters and digits
    std::vector<FarmTask> tasks;
    double seconds = 0;           ///< limit of the wall time of one task
    double bytes = 0;             ///< limit of the memory of one task
    bool after_failures = false;  ///< begins also if a task of the stage before failed
};

struct FarmFilm {
    SceneFile file;
    std::filesystem::path folder;  ///< of the run, absolute
    std::vector<FarmStage> stages;
    std::vector<std::pair<std::filesystem::path, std::string>> files;  ///< that the tasks read, and their content
};

struct FarmOptions {
    std::string on = "local";         ///< local | slurm
    int jobs = 0;                     ///< slurm: tasks of a stage at the same time; 0: no limit
    int threads = 0;                  ///< of each task; 0: local: one per core, slurm: 1
    int pieces = 0;                   ///< of a film that is drawn in pieces; 0: eight, and none shorter than ten frames
    std::vector<std::string> sbatch;  ///< more options of sbatch: "--partition=short"
    bool quiet = false;
};

/// @throws InputError if `on` is unknown or an option has no effect there; EnvironmentError if Slurm is not installed
void check_farm(const FarmOptions& options);

/// The film's stages and files. A film of panels: `panels` (a run each) and `gather`. Any other: `simulate`, `draw` (a range of frames
/// each) and `encode`; without images `simulate` alone. Writes nothing. @throws InputError if the scene is impossible
FarmFilm farm_film(const SceneFile& file, const std::filesystem::path& folder, const FarmOptions& options);

struct FarmEnd {
    std::vector<std::string> failures;  ///< which task, and the last lines that it wrote
    std::string stopped;                ///< the stage that an interrupt ended on this machine; "" if none
};

/// Makes the films, of which it prints the progress on standard error: one after the other on this machine, all together on Slurm, whose
/// job numbers are written to farm/jobs.txt. @return the end of each film; empty: watching Slurm's jobs was interrupted
/// @throws EnvironmentError if Slurm takes no jobs
std::vector<FarmEnd> make_films(const std::vector<FarmFilm>& films, const FarmOptions& options, const InterruptGuard& interrupt);

/// The commands that complete a film of which this stage was interrupted on this machine.
std::string remaining_commands(const SceneFile& file, const std::filesystem::path& folder, const std::string& stage);

}  // namespace whorl

#pragma once
/// A film as stages: independent runs, or one simulation whose frames are drawn in pieces.
#include "tools/farm/stages.h"
#include "tools/film/run_folder.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

struct FarmFilm {
    SceneFile file;
    std::filesystem::path folder;  ///< of the run
    int pieces = 0;                ///< of a film that is drawn in pieces; 0: eight, and none shorter than ten frames
    int threads = 1;               ///< of each task
};

struct FarmWork {
    std::vector<FarmStage> stages;
    std::vector<std::pair<std::filesystem::path, std::string>> files;  ///< what its tasks read, and what is in it
};

struct FarmFolder {
    std::string note;  ///< what became of the run that stood there
    RunFolder held;    ///< no other farm begins in the run's folder meanwhile; its tasks hold the run itself
};

/// A film of panels: `panels` (a run each) and `gather`. Any other: `simulate`, `draw` (a range of frames each) and `encode`; without
/// pictures `simulate` alone. Writes nothing. @throws InputError where the scene is impossible
FarmWork work_of(const FarmFilm& film);
/// Makes the run's folder, with what the tasks read; a run that stands there is kept under another name.
/// @throws InputError where a farm is at work in the folder, or jobs of an earlier one are
FarmFolder begin(const FarmFilm& film, const FarmWork& work);

/// The commands that complete a film of which this stage was interrupted on this machine.
std::string going_on(const FarmFilm& film, const std::string& stage);

/// Those of several films, run together: first with first, second with second.
std::vector<FarmStage> together(const std::vector<std::vector<FarmStage>>& films);

}  // namespace whorl

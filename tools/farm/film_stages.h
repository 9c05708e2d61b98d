#pragma once
/// A film as stages: independent runs, or one simulation whose frames are drawn in pieces.
#include "tools/farm/stages.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

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

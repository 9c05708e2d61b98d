#pragma once
/// Pictures of a run that is over, from the frames that it exported (raw/), without simulating.
#include <filesystem>
#include <string>
#include <vector>

#include "tools/scene_file/scene_file.h"

namespace whorl {

struct RedrawRequest {
    SceneFile file;                 ///< the run's own, with other looks, cameras or sizes put in
    std::filesystem::path run;      ///< the run folder
    std::filesystem::path out;      ///< where frames/ and the video go; may be the run folder, which is held then
    std::vector<std::string> made;  ///< exports that stand there already, of all frames
    int first = 1, last = 0;        ///< frames; last 0: all that there are
    bool quiet = false;
};

/// Draws what render draws, to the bit where the look is the same. What the look leaves open goes by all frames. The video is encoded where
/// all frames are drawn.
/// @return an ExitCode @throws InputError where a frame is missing or damaged
int redraw(const RedrawRequest& request);

/// Numbers of the frames that the run exported, rising.
std::vector<int> exported_frames(const std::filesystem::path& run_folder);

}  // namespace whorl

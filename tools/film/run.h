#pragma once
/// A run from its scene to its run folder: what `whorl render` and `whorl resume` share.
#include <filesystem>
#include <optional>

#include "engine/io/checkpoint.h"
#include "tools/film/run_folder.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

struct RunRequest {
    SceneFile file;
    std::filesystem::path folder;
    std::optional<int> frames;  ///< end with this frame, whatever time.end says
    bool no_draw = false;       ///< frames are exported (raw) and drawn later, by whorl draw
    bool quiet = false, json = false;
    RunFolder::Earlier earlier = RunFolder::Earlier::kept;  ///< treatment of a run that is already in the folder
    std::optional<Checkpoint> from;                         ///< where to resume; nothing: a new run
};

/// What a film does that is not to need ffmpeg. @param goes_on it is resumed
const char* without_video(bool goes_on);
/// Before a film is begun that is to have a video. @throws InputError where a video cannot have so few frames a second
void check_video_rate(const Scene& scene);

/// Simulates, measures, draws, writes; the scene's panels are left out (panels.h runs them). Interrupted by SIGINT or SIGTERM it completes
/// the frames that are on their way, saves the state of the newest one and says how to resume.
/// @return exit_done, exit_failed (diverged) or exit_interrupted
/// @throws InputError before anything is written; EnvironmentError where a video is wanted and there is no ffmpeg, before anything is
/// written, too; or (no EGL device, disk full) with all that was made kept
int run_scene(const RunRequest& request);

}  // namespace whorl

#pragma once
/// A run from its scene to its run folder: common part of `whorl render` and `whorl resume`.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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
    bool force = false;                   ///< resume although a file that the scene names was edited
    bool overwrite = false;               ///< a run that is already in the folder is replaced
    std::optional<Checkpoint> from = {};  ///< where to resume; nothing: a new run
};

/// Before a film is begun that is to have a video. @param here whether this machine encodes it @return the encoder's version
/// @throws InputError if a video cannot have so few frames a second; EnvironmentError if there is no ffmpeg
std::string check_video(const Scene& scene, bool here = true);

/// Simulates, measures, draws, writes; the scene's panels are left out (run_panels() runs them). Interrupted by SIGINT or SIGTERM it
/// completes the frames in progress, saves the state of the last one and prints how to resume.
/// @return exit_done, exit_failed (diverged) or exit_interrupted
/// @throws InputError before anything is written; EnvironmentError where a video is wanted and there is no ffmpeg, before anything is
/// written, too; or (no EGL device, disk full) with all that was made kept
int run_scene(const RunRequest& request);

/// Several runs of one scene, with keys of their own, side by side in one film ([[panel]]).
///
/// Each panel is a normal run, in panels/1, panels/2, ... of the run folder, one after the other. Then their images of one time, with their
/// labels, make one image, over a chart if the scene has one.
/// @param resumed completes the film in its folder: panels that are not done are resumed, or begun
/// @return as run_scene(); where a panel diverged the film ends with its last picture
int run_panels(const RunRequest& request, bool resumed);

/// Completes a request for the run in its folder, whose current scene is request.file: the last valid checkpoint, and the
/// end (request.frames; by default that of the run). Without a checkpoint, the run restarts. Reports damaged checkpoints on standard error.
/// @throws InputError if no checkpoint is valid, if a finished run has none, or if it is of another build or of other settings (all
/// listed)
void resume_from_newest(RunRequest& request);

/// @param made frames that the run has @throws InputError if it is wanted to end before them
void check_end(const std::filesystem::path& folder, const Scene& scene, int made, int wanted);

/// Checks the existing images, with which the video and the contact sheet begin.
/// @throws InputError if one of the `made` is missing, or the first has not the scene's size
void check_pictures(const std::filesystem::path& folder, const Scene& scene, int made);

struct RedrawRequest {
    SceneFile file;                 ///< the run's own, with other looks, cameras or sizes put in
    std::filesystem::path run;      ///< the run folder
    std::filesystem::path out;      ///< where frames/ and the video go; may be the run folder, which is held then
    std::vector<std::string> made;  ///< exports that already exist for all frames
    int first = 1, last = 0;        ///< frames; last 0: all that there are
    bool goes_on = false;           ///< another process still makes frames: each is drawn once it is there
    bool overwrite = false;         ///< replaces another run in `out`, or images of another
    bool quiet = false;
};

/// Values that the look leaves open, from all frames that a run exported, whichever are drawn, so that pieces agree. Also the time
/// that streaks show. @param frames their numbers, rising @throws InputError where one is damaged
SceneFile with_choices_from(SceneFile file, const std::filesystem::path& run, const std::vector<int>& frames);

/// @throws InputError if an unfinished run draws its own images where others are to be drawn
void check_images_free(const std::filesystem::path& run, const std::filesystem::path& out);

/// Draws the images of render, bit-identical for the same look. Values that the look leaves open depend on all frames, or on a coarse run
/// during the run. The video is encoded if all frames are drawn.
/// @return an ExitCode @throws InputError where a frame is missing or damaged
int redraw(const RedrawRequest& request);

/// Numbers of the frames that the run exported, rising.
std::vector<int> exported_frames(const std::filesystem::path& run_folder);

}  // namespace whorl

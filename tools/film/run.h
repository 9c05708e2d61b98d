#pragma once
/// A run from its scene to its run folder: common part of `whorl render` and `whorl resume`.
#include <filesystem>
#include <map>
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
    std::optional<int> frames = {};  ///< number of the last frame, instead of time.end
    bool no_draw = false;            ///< exports raw frames instead of images; whorl draw draws them later
    bool quiet = false, json = false;
    bool force = false;                   ///< resumes even if a file that the scene names was edited
    bool overwrite = false;               ///< replaces an existing run in the folder
    std::optional<Checkpoint> from = {};  ///< checkpoint to continue from; empty: a new run
};

/// Checks before a run that its video can be encoded. @param here false: another machine encodes it, so only time.fps is checked
/// @return version of the encoder; "" without `here` @throws InputError if time.fps is too low; EnvironmentError if ffmpeg is missing
std::string check_video(const Scene& scene, bool here = true);

/// Simulates, measures, draws and writes a scene without its panels (run_panels() runs them). On SIGINT or SIGTERM it completes the frames
/// in progress, saves the state of the last one and prints how to resume.
/// @return exit_done, exit_failed (diverged) or exit_interrupted
/// @throws InputError before anything is written; EnvironmentError if ffmpeg is missing for a video, also before anything is written, or
/// (no EGL device, disk full) later, with all existing files kept
int run_scene(const RunRequest& request);

/// Runs a scene once for each of its panels ([[panel]]), each with its own keys, and shows the runs side by side in one video.
///
/// The panels are normal runs in panels/1, panels/2, ... of the run folder, made in sequence. Then the panels' images of each frame, with
/// labels, are combined into one image, above a chart if the scene has one.
/// @param resumed continues the runs in the folder: panels that are not done are resumed or started
/// @return as run_scene(); if a panel diverged, the video ends with the last frame that all panels have
int run_panels(const RunRequest& request, bool resumed);

/// Completes a request to continue the run in request.folder with the scene request.file: sets request.from to the newest valid checkpoint,
/// and request.frames, if empty, to the end of the run. Without a checkpoint, the run restarts. Reports damaged checkpoints on standard
/// error. @throws InputError if no checkpoint is valid, if a finished run has none, or if the checkpoint was written by another build or
/// with other settings (all are listed)
void resume_from_newest(RunRequest& request);

/// Checks the requested end of a run. @param made number of existing frames @param wanted number of requested frames
/// @throws InputError if wanted < made
void check_end(const std::filesystem::path& folder, const Scene& scene, int made, int wanted);

/// Checks the images of frames 1 to `made`, with which the video and the contact sheet begin.
/// @throws InputError if one is missing, or if the size of the first is not the scene's
void check_pictures(const std::filesystem::path& folder, const Scene& scene, int made);

struct RedrawRequest {
    SceneFile file;                           ///< scene of the run, with changes of the look, camera, surface or output
    std::filesystem::path run;                ///< the run folder
    std::filesystem::path out;                ///< folder of frames/ and the video; may be the run folder, if the caller has locked it
    std::vector<std::string> made;            ///< exports that already exist for all frames
    std::map<std::size_t, Appearance> looks;  ///< new looks of solids and nozzles, by their index in the frames' solids
    int first = 1, last = 0;                  ///< frames to draw; last = 0: to the end
    bool goes_on = false;                     ///< the run is in progress in another process: draws each frame when it is written
    bool overwrite = false;                   ///< replaces another run, or images of another run, in `out`
    bool quiet = false;
};

/// Chooses the colour range, camera box and time of streaks that the scene leaves open, from all raw frames of a run, so that ranges of
/// frames that are drawn separately agree. @param frames numbers of the raw frames, ascending @throws InputError if one is damaged
SceneFile with_choices_from(SceneFile file, const std::filesystem::path& run, const std::vector<int>& frames);

/// Checks whether images can be drawn into `out`. @throws InputError if it is the folder of the unfinished run `run`, which draws its own
/// images there
void check_images_free(const std::filesystem::path& run, const std::filesystem::path& out);

/// Draws raw frames. The images are bit-identical to those of `whorl render` with the same look. Values that the scene leaves open follow
/// from all raw frames, or from a coarse run if the run is in progress. Encodes the video if all frames are drawn.
/// @return an ExitCode @throws InputError if a frame is missing or damaged
int redraw(const RedrawRequest& request);

/// Numbers of the raw frames of the run, ascending.
std::vector<int> exported_frames(const std::filesystem::path& run_folder);

}  // namespace whorl

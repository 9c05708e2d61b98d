#pragma once
/// Several runs of one scene, with keys of their own, side by side in one film ([[panel]]).
///
/// Each panel is a run like any other, in panels/1, panels/2, ... of the run folder, one after the other; their pictures of the same time,
/// with their labels, then make one picture, over a chart where the scene asks for one. A difference of two panels is drawn when both are
/// there. A run that stops goes on with the panel where it stopped.
#include <filesystem>

#include "tools/film/run.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

enum class PanelRuns { fresh, resumed };
/// @return as run_scene(); where a panel diverged the film ends with its last picture
int run_panels(const RunRequest& request, PanelRuns how);

/// Draws into `folder` (frames/) from the frames that both runs exported (raw/). The colour map's range holds 99 % of the fluid in every
/// frame of the film. Where raw/ is gone, pictures that stand there already stay.
/// @param file of the first run @param title of the pictures @throws InputError where a frame is missing or damaged
void draw_differences(const SceneFile& file, const std::string& title, const std::filesystem::path& one, const std::filesystem::path& other,
                      const std::filesystem::path& folder, int frames);

}  // namespace whorl

#pragma once
/// Several runs of one scene, with keys of their own, side by side in one film ([[panel]]).
///
/// Each panel is a run like any other, in panels/1, panels/2, ... of the run folder, one after the other; their pictures of the same time,
/// with their labels, then make one picture. A run that stops goes on with the panel where it stopped.
#include <vector>

#include "tools/film/run.h"

namespace whorl {

/// The scenes of the panels: their keys put in, pictures as large as their place. Panels that show the same field through the same map
/// share its range, so that equal colours mean equal values. @throws InputError with what is wrong with a panel's keys
std::vector<SceneFile> panel_scenes(const SceneFile& file);

/// How many panels stand in a row: as the scene says; in the plane as many as make the flow largest; else all of two or three, from four on
/// about as many as there are rows.
int panel_columns(const Scene& scene);

enum class PanelRuns { fresh, resumed };
/// @return as run_scene(); where a panel diverged the film ends with its last picture
int run_panels(const RunRequest& request, PanelRuns how);

}  // namespace whorl

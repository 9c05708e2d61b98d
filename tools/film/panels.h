#pragma once
/// Several runs of one scene, with keys of their own, side by side in one film ([[panel]]).
///
/// Each panel is a run like any other, in panels/1, panels/2, ... of the run folder, one after the other; their pictures of the same time,
/// with their labels, then make one picture, over a chart where the scene asks for one. A difference of two panels is drawn when both are
/// there. A run that stops goes on with the panel where it stopped.
#include "tools/film/run.h"

namespace whorl {

enum class PanelRuns { fresh, resumed };
/// @return as run_scene(); where a panel diverged the film ends with its last picture
int run_panels(const RunRequest& request, PanelRuns how);

}  // namespace whorl

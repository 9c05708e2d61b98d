#pragma once
/// Warnings, before a run, about a camera that shows nothing.
#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Warns if the camera is at its target, looks along camera.up, does not see the domain, or is so far away that the domain covers less
/// than 2 % of the image's height.
std::vector<std::string> camera_warnings(const SceneFile& file);

/// Plan of the scene, with the warnings about its camera.
Plan make_plan(const SceneFile& file);

}  // namespace whorl

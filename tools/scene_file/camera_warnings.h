#pragma once
/// Warnings about a camera that shows nothing, before the film is made.
#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Warns if the camera is at its target, looks away from the domain, or is too far away to see more than a speck.
std::vector<std::string> camera_warnings(const SceneFile& file);

/// The plan of the scene, with warnings of its camera.
Plan make_plan(const SceneFile& file);

}  // namespace whorl

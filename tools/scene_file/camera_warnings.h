#pragma once
/// A camera that shows nothing: told before the film is made.
#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// A warning where the camera sits in its target, looks away from the domain, or is so far away that the domain is a speck.
std::vector<std::string> camera_warnings(const SceneFile& file);

/// The plan of the scene, with warnings of its camera.
Plan make_plan(const SceneFile& file);

}  // namespace whorl

#pragma once
/// A small scene with the models of a large one: what the cost of a scene is measured on before it is run.
#include "engine/scene/plan.h"
#include "tools/options.h"

namespace whorl {

/// About three thousand particles in the situation that the scene is about: a rope that runs onto a floor where the scene has emitters and
/// nothing else, a tank half full where it has solids, a turning drop where it has none, a shear flow where every axis is periodic.
/// Spacing, models, options, gravity and viscosity are the scene's own.
SceneFile sample_of(const SceneFile& file, const Plan& plan);

}  // namespace whorl

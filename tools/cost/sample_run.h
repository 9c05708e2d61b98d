#pragma once
/// A small scene with the models of a large one: what the cost of a scene is measured on before it is run.
#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// About a thousand to three thousand particles in the situation that the scene is about: a rope on a floor that its nozzle pushes and
/// bends where the scene has emitters and nothing else, a tank half full where it has solids, a turning drop where it has none, a shear
/// flow where every axis is periodic. Spacing, models, options, gravity and viscosity are the scene's own.
SceneFile sample_of(const SceneFile& file, const Plan& plan);

/// How many particles the rope has: as many as the scene in the end, within bounds; few cost more each.
double poured_particles(const Plan& plan);
/// Half the thickness of what an emitter lets out, in spacings, as the small scene has it.
double half_thickness(const EmitterKeys& emitter, double spacing);

}  // namespace whorl

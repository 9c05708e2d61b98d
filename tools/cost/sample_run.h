#pragma once
/// Small runs that a film is judged by before it is run: few particles with its models, and its whole flow with larger particles.
#include <functional>

#include "engine/io/frame.h"
#include "engine/scene/plan.h"
#include "engine/sim/simulation.h"
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

/// Runs the scene with a larger spacing and shows its start and `moments` moments, evenly spaced up to the film's end. In space it takes
/// about 1/coarser^4 of the time, in the plane 1/coarser^3.
/// @param fields what the frames hold beside place and velocity
/// @param progress the part of the time that is done, after every step
/// @return false where the coarse scene is impossible or diverges, whatever was shown
bool run_coarsely(
    const SceneFile& file, double coarser, int moments, const std::vector<std::string>& fields,
    const std::function<void(const Frame&, const Simulation&)>& show, const std::function<void(double)>& progress = [](double) {});

/// The frame of a coarse run with the film's own number of particles: each stands for `coarser` along every axis, which carry what it has.
Frame parted(const Frame& coarse, int coarser);

}  // namespace whorl

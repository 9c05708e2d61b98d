#pragma once
/// What only the flow itself can tell, found before the film by running it coarsely.
#include <array>

#include "engine/sim/simulation.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// The colour map's range for a film: the look's own where it has one. Else the scene is run at twice its spacing (an eighth of the time in
/// the plane, a sixteenth in space), and the range holds 99 % of the particles at each of 24 moments. Where that cannot be run, where the
/// scene changes on its way, and for density, the estimate of film_range().
/// @param start the run at its beginning @param frames of the film @param quiet say nothing on the terminal
std::array<float, 2> first_pass_range(const SceneFile& file, const Simulation& start, int frames, bool quiet);

}  // namespace whorl

#pragma once
/// What only the flow itself can tell, found before the film by running it coarsely.
#include "engine/sim/simulation.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// The scene with what it leaves open for a whole film to have: the range of its colour map, and the box that an automatic camera shows, as
/// the scene alone lets them be estimated (film_range(), foreseen_extent()). @param start the run at its beginning
SceneFile with_estimates(SceneFile file, const Simulation& start);

/// The same from the flow itself: the scene is run to its end at twice its spacing (an eighth of the time in the plane, a sixteenth in
/// space). The range then holds 99 % of the particles at each of 24 moments, the box what is seen at them (add_seen()). Where that cannot
/// be run and where there are no pictures, both are estimates. So is the range of density.
/// @param start the run at its beginning @param quiet say nothing on the terminal
SceneFile with_first_pass(SceneFile file, const Simulation& start, bool quiet);

/// The same from the frames that a run exported, all of them whichever are drawn, so that pieces agree. Also the time that streaks show.
/// @param frames their numbers, rising @throws InputError where one is damaged
SceneFile with_choices_from(SceneFile file, const std::filesystem::path& run, const std::vector<int>& frames);

}  // namespace whorl

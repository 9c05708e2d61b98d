#pragma once
/// The camera box and the colour range of a whole film, found before it: from the scene alone, or from a coarse run.
#include <Eigen/Geometry>

#include "engine/io/frame.h"
#include "engine/sim/simulation.h"
#include "render/look/look_options.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

using Extent = Eigen::AlignedBox3f;  ///< m, in the world's axes

/// Grows by what a frame shows: 99 % of the fluid along each axis, so that a few drops do not widen the picture; the openings that fluid
/// comes from; the solids that stand elsewhere than at the start. Nothing outside of the domain counts.
void add_seen(Extent& extent, const Frame& frame, const Frame& start);

/// Grows by the solids that reach into it, where that makes it less than half larger: the plate under honey is seen whole, a floor is not.
/// @param frame the start
void add_still_solids(Extent& extent, const Frame& frame);

/// All of this for a whole film, from its scene alone: the fluid at the start and in the openings, where it lands when it falls or flies
/// freely until a solid or the domain stops it, and the way of solids with a motion of their own. Fluid that lands spreads about as far as
/// the edge of a cube that holds all of it.
Extent foreseen_extent(const Simulation& start);

/// Whether the film has an automatic camera that still wants its box. A slice that fills the picture has no camera.
bool wants_extent(const SceneFile& file);

/// Gives an automatic camera the extent as its box, in numbers rounded outwards. An empty one changes nothing.
void look_at(CameraOptions& camera, const Extent& extent);

/// Whether the look shows a field and leaves the range of its colours open.
bool wants_range(const LookOptions& look);

/// The next of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten. @param value above 0
double round_number_above(double value);

/// The way that streaks and arrows of a slice show [s], the same for every frame of the film: as the look says, else as long as a frame
/// lasts, or what the fastest fluid takes for a few hundredths of the domain.
float film_streak_time(const LookOptions& look, const Simulation& simulation);

/// The scene with what it leaves open for a whole film, as estimated from the scene alone: the range of its colour map and the box of an
/// automatic camera. @param start the run at its beginning
SceneFile with_estimates(SceneFile file, const Simulation& start);

/// The same from the flow itself: the scene is run to
/// its end at three times its spacing (a 27th of the time in the plane, an 81st in space). The range then holds 99 % of the particles at
/// each of 24 moments, the box what is seen at them (add_seen()). If that cannot be run, and without images, both are estimates from the
/// scene alone. So are the range of density and the box of a room that is full at the start.
/// @param start the run at its beginning @param quiet say nothing on the terminal
/// @throws Interrupted
SceneFile with_first_pass(SceneFile file, const Simulation& start, bool quiet);

/// The same from the frames that a run exported, all of them whichever are drawn, so that pieces agree. Also the time that streaks show.
/// @param frames their numbers, rising @throws InputError where one is damaged
SceneFile with_choices_from(SceneFile file, const std::filesystem::path& run, const std::vector<int>& frames);

}  // namespace whorl

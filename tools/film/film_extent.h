#pragma once
/// Where a film's fluid and moving solids are, for an automatic camera to show.
#include <Eigen/Geometry>

#include "engine/sim/simulation.h"
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

}  // namespace whorl

#pragma once
/// The camera's box and the range of the colours for a whole film: from its scene alone, or from frames.
#include <Eigen/Geometry>
#include <optional>

#include "engine/io/frame.h"
#include "engine/simulation/simulation.h"
#include "render/look/look_options.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

using SeenBox = Eigen::AlignedBox3f;  ///< m, in the world's axes

/// Grows by what a frame shows: 99 % of the fluid along each axis, so that a few drops do not widen the picture; the openings that fluid
/// comes from; the solids that have moved since the start. Nothing outside of the domain counts.
void add_seen(SeenBox& extent, const Frame& frame, const Frame& start);

/// All of this for a whole film, from its scene alone: the fluid at the start and in the openings, where it lands when it falls or flies
/// freely until a solid or the domain stops it, and the way of solids with a motion of their own. Fluid that lands spreads about as far as
/// the edge of a cube that holds all of it.
SeenBox foreseen_extent(const Simulation& start);

/// Whether the film has an automatic camera that still wants its box. A slice that fills the picture has no camera.
bool wants_extent(const SceneFile& file);

/// Gives an automatic camera the extent as its box, in numbers rounded outwards. An empty one changes nothing.
void look_at(CameraOptions& camera, const SeenBox& extent);

/// Whether the look shows a field and leaves the range of its colours open.
bool wants_range(const LookOptions& look);

/// The next of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten. @param value above 0
double round_number_above(double value);

/// Whether the look has streaks or arrows and leaves open what time they show.
bool wants_streak_time(const LookOptions& look);

/// The scene with what it leaves open for a whole film, as estimated from the scene alone: the range of its colour map, the box of an
/// automatic camera, and the time that streaks and arrows show, which is as long as a frame lasts, or what the fastest fluid takes for a
/// few hundredths of the domain. @param start the run at its beginning
SceneFile with_estimates(SceneFile file, const Simulation& start);

/// Extent and ranges of a film's frames, in order.
class Seen {
public:
    explicit Seen(const LookOptions& look) : look_(look) {}
    void add(const Frame& frame);
    SeenBox extent() const;
    /// The largest, over the frames, of what 99 % of the look's field stays below in size.
    float size() const { return size_; }

private:
    LookOptions look_;
    std::optional<Frame> start_;
    float size_ = 0;
    SeenBox extent_;
};

/// Whether the range of the colours depends on the flow: density keeps to 3 % about rest, inks to 1.
bool measures_range(const LookOptions& look);

/// Puts what frames showed into what the scene leaves open. An empty extent and a size of 0 leave it open.
void choose(SceneFile& file, const SeenBox& extent, float size);

}  // namespace whorl

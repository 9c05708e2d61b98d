#pragma once
/// Camera box, colour range and streak time for a whole run, from the scene alone or from frames.
#include <Eigen/Geometry>
#include <optional>

#include "engine/io/frame.h"
#include "engine/simulation/simulation.h"
#include "render/look/look_options.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

using SeenBox = Eigen::AlignedBox3f;  ///< box that a camera shall show, along the world's axes [m]

/// Extends the box by a frame's content inside the domain: along each axis the middle 99 % of the fluid, so that a few drops do not widen
/// the image; the openings of the emitters; the solids that have moved since the start, at both positions. @param start first frame
void add_seen(SeenBox& extent, const Frame& frame, const Frame& start);

/// Predicts the box of a whole run from the scene alone. It contains the fluid at the start, the openings of the emitters, the points where
/// fluid lands after a free flight, and the paths of solids with a prescribed motion. Solids and the domain's sides stop the flight. Landed
/// fluid is assumed to spread, normal to gravity, by the edge length of a cube (in 2D: a square) of all fluid.
SeenBox foreseen_extent(const Simulation& start);

/// Whether the scene has an automatic camera without a box. A slice fills the image and has no camera.
bool wants_extent(const SceneFile& file);

/// Sets the box of an automatic camera, rounded outwards to a hundredth or thousandth of its size. An empty box changes nothing.
void look_at(CameraOptions& camera, const SeenBox& extent);

/// Whether the look shows a field without a given colour range.
bool wants_range(const LookOptions& look);

/// Smallest of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten that is at least `value`. @param value above 0
double round_number_above(double value);

/// Whether the look has streaks or arrows without a given streak_time.
bool wants_streak_time(const LookOptions& look);

/// Returns the scene with colour range, camera box and streak_time set if the scene leaves them open, estimated from the scene alone.
/// streak_time is the frame interval, bounded by the times in which the fastest fluid moves 1/45 and 1/16 of the domain's longest edge.
/// @param start simulation at the start
SceneFile with_estimates(SceneFile file, const Simulation& start);

/// Camera box and range of the shown field, accumulated over a run's frames in order of time.
class Seen {
public:
    explicit Seen(const LookOptions& look) : look_(look) {}
    void add(const Frame& frame);
    SeenBox extent() const;
    /// Maximum over the frames of the 99th percentile of the shown field's magnitude.
    float size() const { return size_; }

private:
    LookOptions look_;
    std::optional<Frame> start_;
    float size_ = 0;
    SeenBox extent_;
};

/// Whether the colour range is open and depends on the flow. Density and ink have fixed ranges: 3 % about the rest density, 0 to 1.
bool measures_range(const LookOptions& look);

/// Sets camera box and colour range if the scene leaves them open. @param extent empty: the box stays open @param size 99th percentile of
/// the field's magnitude; 0: unknown, the range stays open. The range of density does not depend on size; that of ink stays open.
void choose(SceneFile& file, const SeenBox& extent, float size);

}  // namespace whorl

#pragma once
/// Ghost particles that continue the fluid beyond periodic faces and container walls, and the cut at those sides.
#include <array>
#include <memory>
#include <vector>

#include "engine/io/frame.h"
#include "render/surface/wall_field.h"

namespace whorl {

/// The frame's particles, in their order, followed by their copies within `margin` beyond the periodic sides.
struct Ghosted {
    std::vector<Vec3f> position;
    std::vector<Index> original;  ///< index in the frame; empty if nothing is periodic: position is the frame's
};
Ghosted with_ghosts(const Frame& frame, float margin);

/// Surfaces at which the fluid is cut off: the sides of a periodic domain, the walls of convex containers and those of solids of glass or
/// ice, such as open vessels. A container that is not convex has no planes; in it the surface is that of the particles alone.
class Cut {
public:
    using Side = CutSide;
    Cut() = default;
    explicit Cut(const Frame& frame);

    bool any() const { return !sides_.empty() || !glass_.empty(); }
    /// Side with the least inside(x). There must be a side.
    Side at(const Vec3f& x) const;
    /// Number of sides nearer than `reach` [m] that meet in an edge or a corner (are_across()), at most three.
    int count_at(const Vec3f& x, float reach) const { return corner_at(x, reach).count; }
    /// The sides that matter to points within `radius` [m] of x: such a point is nearer to the side than `reach` [m], or beyond it. Omits
    /// sides that other sides hide from all these points, such as further facets of a round wall.
    Cut near(const Vec3f& x, float radius, float reach) const;
    /// Point where the colour at x is found: x, but at least `least` [m] away from glass. The fluid is taken to be the same along that way.
    Vec3f off_glass(const Vec3f& x, float least) const;
    bool any_glass() const { return !glass_.empty(); }
    /// Mirror images of the particles within `margin` [m] of the walls, also at corners. With them the surface reaches the walls.
    std::vector<Vec3f> images(const std::vector<Vec3f>& position, float margin) const;
    /// x, moved onto the walls nearer than `reach` [m], so that the edge between two walls is sharp.
    Vec3f onto_walls(const Vec3f& x, float reach) const;
    /// Corrected position of a vertex that smoothing moved. A vertex on a periodic side (within `tolerance` [m]) returns to `original`, so
    /// that both ends of a period fit together. A vertex on a wall may only slide along it.
    Vec3f held(const Vec3f& original, const Vec3f& moved, float tolerance) const;

private:
    /// The side nearest to a point, and the sides that meet it in an edge. Of the facets of a round wall only the nearest counts.
    struct Corner {
        std::array<Side, 3> side;
        int count = 0;
        bool is_at_glass = false;
    };
    Corner corner_at(const Vec3f& x, float reach) const;
    /// Whether x is at least this deep in glass [m].
    bool is_in_glass(const Vec3f& x, float depth) const;

    std::vector<Side> sides_;
    std::vector<std::shared_ptr<const WallField>> glass_;
};
/// Upper bound of the colour at a distance `inside` [m] from the cut. On the cut it is iso.
inline float cut_colour(float inside, float iso, float reach) { return iso + inside / reach; }

}  // namespace whorl

#pragma once
/// Ghost particles that continue the fluid beyond periodic faces and container walls, and the cut at those sides.
#include <array>
#include <vector>

#include "engine/io/frame.h"

namespace whorl {

/// The frame's particles, in their order, followed by their copies within `margin` beyond the periodic sides.
struct Ghosted {
    std::vector<Vec3f> position;
    std::vector<Index> original;  ///< index in the frame; empty if nothing is periodic: position is the frame's
};
Ghosted with_ghosts(const Frame& frame, float margin);

/// The planes at which the fluid is cut off: the sides of a periodic domain and the walls of convex containers. A container that is not
/// convex has no planes; in it the surface is that of the particles alone.
class Cut {
public:
    struct Side {
        Vec3f inward;                                                          ///< unit normal, towards the fluid
        float offset;                                                          ///< m, inward . x of its points
        bool is_wall;                                                          ///< wall of a container; false: side of a periodic domain
        float inside(const Vec3f& x) const { return inward.dot(x) - offset; }  ///< distance from the side [m], negative beyond it
    };
    Cut() = default;
    explicit Cut(const Frame& frame);

    bool any() const { return !sides_.empty(); }
    /// Side with the least inside(x). There must be a side.
    const Side& at(const Vec3f& x) const;
    /// Number of sides nearer than `reach` [m] that meet in an edge or a corner (are_across()), at most three.
    int count_at(const Vec3f& x, float reach) const { return corner_at(x, reach).count; }
    /// The sides that matter to points within `radius` [m] of x: such a point is nearer to the side than `reach` [m], or beyond it. Omits
    /// sides that other sides hide from all these points, such as further facets of a round wall.
    Cut near(const Vec3f& x, float radius, float reach) const;
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
        std::array<const Side*, 3> side;
        int count = 0;
    };
    Corner corner_at(const Vec3f& x, float reach) const;
    /// Whether the sides meet in an edge: the angle between them is too large for facets of one round wall.
    static bool are_across(const Side& a, const Side& b) { return std::abs(a.inward.dot(b.inward)) < 0.7f; }

    std::vector<Side> sides_;
};
/// Upper bound of the colour at a distance `inside` [m] from the cut. On the cut it is iso.
inline float cut_colour(float inside, float iso, float reach) { return iso + inside / reach; }

}  // namespace whorl

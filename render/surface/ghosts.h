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

/// The planes at which the fluid is cut off: the sides of a periodic domain and the walls of convex containers. A container whose wall has
/// a hollow or a bulge has no planes; the fluid ends there with its particles.
class Cut {
public:
    struct Side {
        Vec3f inward;                                                          ///< its normal
        float offset;                                                          ///< m: inward.x of its points
        bool is_wall;                                                          ///< of a container
        float inside(const Vec3f& x) const { return inward.dot(x) - offset; }  ///< m from the side, negative beyond it
    };
    Cut() = default;
    explicit Cut(const Frame& frame);

    bool any() const { return !sides_.empty(); }
    /// Side with the least inside(x). There must be a side.
    const Side& at(const Vec3f& x) const;
    /// How many sides, up to three across each other, are nearer than `reach`.
    int count_at(const Vec3f& x, float reach) const { return corner_at(x, reach).count; }
    /// The sides that any point within `radius` of x can have within `reach` or beyond them. Sides that others hide there, such as the
    /// facets of a round wall, are left out.
    Cut near(const Vec3f& x, float radius, float reach) const;
    /// Mirror images of the particles within `margin` of the walls, also at corners, so that water fills its glass.
    std::vector<Vec3f> images(const std::vector<Vec3f>& position, float margin) const;
    /// x moved onto the walls that are nearer than `reach`, so that the edge between two walls is sharp.
    Vec3f onto_walls(const Vec3f& x, float reach) const;
    /// Corrects a vertex on sides after smoothing moved it: on periodic sides it returns to its position, so that both ends of a period fit
    /// together; on walls it may move along them.
    Vec3f held(const Vec3f& original, const Vec3f& moved, float tolerance) const;

private:
    /// The side nearest to a point, and the sides across it. Of the facets of a round wall only the nearest counts.
    struct Corner {
        std::array<const Side*, 3> side;
        int count = 0;
    };
    Corner corner_at(const Vec3f& x, float reach) const;
    /// Whether the angle between the sides is so large that they meet in an edge instead of being facets of one wall.
    static bool are_across(const Side& a, const Side& b) { return std::abs(a.inward.dot(b.inward)) < 0.7f; }

    std::vector<Side> sides_;
};
/// Upper bound of the colour at a distance `inside` from the cut: iso on the cut.
inline float cut_colour(float inside, float iso, float reach) { return iso + inside / reach; }

}  // namespace whorl

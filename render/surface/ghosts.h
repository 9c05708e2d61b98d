#pragma once
/// Periodic domains: the copies of the particles just beyond each periodic side, and the cut at that side.
#include <limits>

#include "engine/io/frame.h"

namespace whorl {

/// The frame's particles (those first, in their order) and their copies within `margin` beyond the periodic sides.
struct Ghosted {
    std::vector<Vec3f> position;
    std::vector<Index> original;  ///< index in the frame; empty where nothing is periodic: position is the frame's own
};
Ghosted with_ghosts(const Frame& frame, float margin);

/// The sides of the domain at which a periodic fluid is cut off; infinitely far on axes that are not periodic.
struct Cut {
    Vec3f low = Vec3f::Constant(-std::numeric_limits<float>::infinity()), high = -low;
    bool any() const { return (low.array() > -std::numeric_limits<float>::infinity()).any(); }

    struct Side {
        float inside;  ///< m from the nearest side, negative beyond it
        Vec3f inward;  ///< its normal
    };
    Side at(const Vec3f& x) const {
        Side side{std::numeric_limits<float>::infinity(), Vec3f::Zero()};
        for (int a = 0; a < 3; ++a) {
            if (x[a] - low[a] < side.inside) side = {x[a] - low[a], Vec3f::Unit(a)};
            if (high[a] - x[a] < side.inside) side = {high[a] - x[a], -Vec3f::Unit(a)};
        }
        return side;
    }
};
Cut cut_of(const Frame& frame);
/// The colour that the fluid has at most where it is `inside` of the cut: iso on it.
inline float cut_colour(float inside, float iso, float reach) { return iso + inside / reach; }

}  // namespace whorl

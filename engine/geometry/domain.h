#pragma once
/// The box that contains the particles. Any of its axes may be periodic. In 2D the box has no depth and lies in the plane z = 0.
#include <array>
#include <cmath>

#include "engine/core/types.h"

namespace whorl {

struct Domain {
    Vec3 min = Vec3::Zero();                            ///< m
    Vec3 max = Vec3::Ones();                            ///< m
    std::array<bool, 3> periodic{false, false, false};  ///< a periodic axis must be at least two support radii long

    int dimensions() const { return min.z() < max.z() ? 3 : 2; }
    bool any_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
    /// Whether the domain has no boundary.
    bool all_periodic() const { return periodic[0] && periodic[1] && (periodic[2] || dimensions() == 2); }
    /// m^3; in 2D m^2, the volume per metre of depth.
    double volume() const {
        const Vec3d size = (max - min).cast<double>();
        return size.x() * size.y() * (dimensions() == 2 ? 1 : size.z());
    }
    Vec3 size() const { return max - min; }
    bool contains(const Vec3& x) const {
        for (int a = 0; a < 3; ++a)
            if (!periodic[a] && !(x[a] >= min[a] && x[a] <= max[a])) return false;
        return true;
    }
    /// Length of each periodic axis [m], 0 for the others. Loops that use it for the nearest image need only multiply-adds, no branch.
    Vec3 period() const {
        Vec3 L = Vec3::Zero();
        for (int a = 0; a < 3; ++a)
            if (periodic[a]) L[a] = max[a] - min[a];
        return L;
    }
    /// The displacement between nearest periodic images of two points that are r apart.
    Vec3 minimum_image(Vec3 r) const {
        for (int a = 0; a < 3; ++a)
            if (periodic[a]) {
                const Real L = max[a] - min[a];
                r[a] -= L * std::nearbyint(r[a] / L);
            }
        return r;
    }
    /// Whether one of the periodic images of x lies in the box [low, high]; x becomes that image.
    template <class V>
    bool image_in_box(V& x, const V& low, const V& high) const {
        for (int a = 0; a < 3; ++a) {
            if (x[a] >= low[a] && x[a] <= high[a]) continue;
            if (!periodic[a]) return false;
            const typename V::Scalar L = max[a] - min[a];
            x[a] -= L * std::floor((x[a] - low[a]) / L);
            if (!(x[a] <= high[a])) return false;
        }
        return true;
    }
    /// x moved into [min, max) along the periodic axes.
    Vec3 wrapped(Vec3 x) const {
        for (int a = 0; a < 3; ++a)
            if (periodic[a]) {
                const Real L = max[a] - min[a];
                x[a] -= L * std::floor((x[a] - min[a]) / L);
                if (x[a] >= max[a]) x[a] = min[a];
            }
        return x;
    }
};

}  // namespace whorl

#include "engine/models/boundary/near_walls.h"

#include <cmath>
#include <limits>

namespace whorl {

bool NearWalls::meet(Real reach) const {
    for (std::size_t k = 0; k < count && height[k] < reach; ++k)
        for (std::size_t l = 0; l < k; ++l)
            if (std::abs(normal[k].dot(normal[l])) < Real(0.9)) return true;
    return false;
}

Real NearWalls::least_gap() const {
    Real least = std::numeric_limits<Real>::infinity();
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t l = 0; l < k; ++l)
            if (normal[k].dot(normal[l]) < Real(-0.5)) least = std::min(least, height[k] + height[l]);
    return least;
}

NearWalls walls_near(const InteractionContext& context, Index i, Real reach) {
    NearWalls found;
    const BoundaryParticles& boundary = context.boundary;
    const Real d = context.step.spacing;
    // Whether the fluid lies between two walls: a part of each is in front of the other.
    const auto facing = [&](const Vec3& normal, Real height, std::size_t other) {
        bool front[2] = {false, false};
        context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
            const Vec3& n = boundary.normal[s];
            front[0] = front[0] || (n.dot(normal) > Real(0.9) && found.above(other, -r) > d / 4);
            front[1] = front[1] || (n.dot(found.normal[other]) > Real(0.9) && height - r.dot(normal) > d / 4);
        });
        return front[0] && front[1];
    };
    std::array<Vec3, NearWalls::most> seen;
    std::size_t directions = 0;
    while (directions < seen.size()) {
        Real least = reach;
        Index nearest = -1;
        context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
            const Real height = r.dot(boundary.normal[s]) - d / 2;
            if (height < -d / 2 || height >= least) return;
            for (std::size_t k = 0; k < directions; ++k)
                if (seen[k].dot(boundary.normal[s]) > Real(0.5)) return;
            least = height, nearest = s;
        });
        if (nearest < 0) break;
        const Vec3 normal = seen[directions++] = boundary.normal[nearest];
        bool between = true;
        for (std::size_t k = 0; k < found.count; ++k) between = between && facing(normal, least, k);
        if (between) found.normal[found.count] = normal, found.height[found.count++] = least;
    }
    return found;
}

}  // namespace whorl

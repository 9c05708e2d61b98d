#include "engine/models/boundary/near_walls.h"

#include <algorithm>
#include <cmath>

namespace whorl {

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
        bool between = true, crosses = false;
        for (std::size_t k = 0; k < found.count; ++k) {
            between = between && facing(normal, least, k);
            crosses = crosses || std::abs(found.normal[k].dot(normal)) < Real(0.9);
        }
        if (!between) continue;
        found.meet = found.meet || crosses;
        found.normal[found.count] = normal, found.height[found.count] = least, found.nearest[found.count++] = nearest;
    }
    return found;
}

}  // namespace whorl

#pragma once
/// Flat walls near a particle, and the edges in which they meet.
#include <array>

#include "engine/particles/interaction_context.h"

namespace whorl {

/// Flat walls near a particle, one for each direction, the nearest first.
struct NearWalls {
    static constexpr std::size_t most = 6;
    std::size_t count = 0;
    std::array<Vec3, most> normal;  ///< into the fluid
    std::array<Real, most> height;  ///< of the particle above the wall [m]
    /// Height above wall k of the point at `from_particle` [m], relative to the particle.
    Real above(std::size_t k, const Vec3& from_particle) const { return height[k] + from_particle.dot(normal[k]); }
    /// Whether two of the walls within `reach` [m] of the particle are not parallel.
    bool meet(Real reach) const;
    /// Smallest distance between two of the walls that face each other [m]; infinite if none do.
    Real least_gap() const;
};

/// The walls within `reach` [m] of particle i that face each other or meet in a concave edge. Of walls that meet in a convex edge, only the
/// nearest.
NearWalls walls_near(const InteractionContext& context, Index i, Real reach);

}  // namespace whorl

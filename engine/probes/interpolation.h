#pragma once
/// Interpolation of fields between particles.
#include <vector>

#include "engine/simulation/world.h"

namespace whorl {

/// Value of a field at a point as a sum over particles: f(point) = sum weight f(particle).
struct Interpolation {
    struct Share {
        Index particle = 0;
        double weight = 0;
    };
    std::vector<Share> shares;  ///< empty: no fluid within three spacings
};

/// For each point, the particles within `radius` [m] (to the nearest periodic image) and possibly a few more, in the order of the store.
std::vector<std::vector<Index>> particles_near(const World& world, const std::vector<Vec3d>& points, double radius);

/// Interpolates at each point by weighted least squares with the best quadratic function of position for the particles within three
/// spacings. Quadratic fields are therefore exact, also up to a wall. Terms that these particles cannot distinguish are left out. Outside
/// the fluid only the constant term is used, which gives the mean of the nearest particles. Particles in nozzles do not count.
std::vector<Interpolation> interpolate(const World& world, const std::vector<Vec3d>& points);

}  // namespace whorl

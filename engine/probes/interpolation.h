#pragma once
/// Fields between the particles.
#include <vector>

#include "engine/simulation/world.h"

namespace whorl {

/// The value of a field at a point as a sum over particles: f(point) = sum weight f(particle).
struct Interpolation {
    struct Share {
        Index particle = 0;
        double weight = 0;
    };
    std::vector<Share> shares;  ///< empty: no fluid within three spacings
};

/// For each of the points the particles within `radius` [m], to the nearest periodic image, in the order of the store; a few more.
std::vector<std::vector<Index>> particles_near(const World& world, const std::vector<Vec3d>& points, double radius);

/// Interpolates at each point by weighted least squares: the quadratic function of place that fits the particles within three spacings
/// best. So quadratic fields are exact, also up to a wall. Terms that these particles cannot distinguish are left out, and outside of the
/// fluid all except the constant one: there the value is the mean of the nearest particles. Particles in nozzles do not count.
std::vector<Interpolation> interpolate(const World& world, const std::vector<Vec3d>& points);

}  // namespace whorl

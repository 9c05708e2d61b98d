#pragma once
/// Fields between the particles.
#include <vector>

#include "engine/sim/world.h"

namespace whorl {

/// The value of a field at a point as a sum over particles: f(point) = sum weight f(particle).
struct Interpolation {
    struct Share {
        Index particle = 0;
        double weight = 0;
    };
    std::vector<Share> shares;  ///< empty: no fluid within three spacings
    bool in_fluid = false;      ///< a particle is within 1.2 spacings

    double operator()(Span<const Real> f) const {
        double sum = 0;
        for (const Share& one : shares) sum += one.weight * static_cast<double>(f[static_cast<std::size_t>(one.particle)]);
        return sum;
    }
    Vec3d operator()(Span<const Vec3> f) const {
        Vec3d sum = Vec3d::Zero();
        for (const Share& one : shares) sum += one.weight * f[static_cast<std::size_t>(one.particle)].cast<double>();
        return sum;
    }
};

/// For each of the points the particles within `radius` [m], to the nearest periodic image, in the order of the store; all particles if a
/// periodic axis is too short for a search.
std::vector<std::vector<Index>> particles_near(const World& world, const std::vector<Vec3d>& points, double radius);

/// Interpolates by weighted least squares: the quadratic function of place that fits the particles within three spacings best. So quadratic
/// fields are exact, up to a wall too. Terms that these particles do not tell apart are left out, and outside of the fluid all but the
/// constant one: there the value is the mean of the nearest particles. Particles in nozzles do not count.
/// @param among the particles that may be near
Interpolation interpolate(const World& world, const Vec3d& point, const std::vector<Index>& among);
/// Among all particles.
Interpolation interpolate(const World& world, const Vec3d& point);
/// The same at each of many points.
std::vector<Interpolation> interpolate(const World& world, const std::vector<Vec3d>& points);

}  // namespace whorl

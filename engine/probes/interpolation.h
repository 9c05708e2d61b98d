#pragma once
/// Fields between the particles.
#include <vector>

#include "engine/sim/world.h"

namespace whorl {

/// What a particle contributes to the value at a point: f(point) = sum weight f(particle).
struct Contribution {
    Index particle = 0;
    double weight = 0;
};

/// Interpolates by weighted least squares: the quadratic function of place that fits the particles within three spacings best. So quadratic
/// fields are exact, up to a wall too. Terms that these particles do not tell apart are left out, and all but the constant one where no
/// particle is within 1.2 spacings: outside of the fluid the value is the mean of the nearest particles. Particles in nozzles do not count.
/// Empty: no fluid within three spacings.
std::vector<Contribution> interpolate(const World& world, const Vec3d& point);

}  // namespace whorl

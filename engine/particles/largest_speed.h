#pragma once
/// The speed that limits a step.
#include <cmath>

#include "engine/core/parallel.h"

namespace whorl {

/// m/s, the largest of all particles; 0 where there are none.
inline double largest_speed(Span<const Vec3> u) {
    return std::sqrt(parallel_max(static_cast<Index>(u.size()), 0, [&](Index i) { return static_cast<double>(u[i].squaredNorm()); }));
}

}  // namespace whorl

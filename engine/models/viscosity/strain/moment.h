#pragma once
/// Moments of a particle's neighbours, for all models with least-squares gradients.
#include <algorithm>

#include "engine/core/types.h"

namespace whorl {

/// 0 for t <= 0, 1 for t >= 1, smooth between.
inline double smooth_step(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// Ratios of an eigenvalue to the largest one. A direction is unresolved up to the first ratio and fully resolved from the second one.
inline constexpr double unresolved_at = 0.01, resolved_above = 0.04;

/// Inverse of the moment matrix M = sum w r r^T = Q diag(s) Q^T, s ascending. A single neighbour, and neighbours on a line or in a plane,
/// do not resolve the directions across. The resolution pi of direction a is a smooth step of ln(s_a/s_max) between the two ratios above.
struct Moment {
    Mat3d inverse = Mat3d::Zero();   ///< M+ = Q diag(pi/s) Q^T
    Mat3d resolved = Mat3d::Zero();  ///< P = Q diag(pi) Q^T
    double unresolved = 3;           ///< k = sum (1 - pi^2) over the dimensions: 0 in a volume, 1 in a sheet, 2 in a single file
    bool whole = false;              ///< all directions are resolved
};

inline bool resolves_all(const Vec3d& s) { return s[0] >= resolved_above * s[2]; }
/// @param dimensions if 2, the third row and column of M and of its inverse are 0
Moment invert_moment(const Vec3d& s, const Mat3d& Q, int dimensions = 3);
/// Skips the eigenvalues if all directions are clearly resolved.
Moment invert_moment(const Mat3d& M, int dimensions = 3);

}  // namespace whorl

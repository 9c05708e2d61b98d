
#include "engine/math/inverse_in.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace whorl {

Mat3d pseudo_inverse(const Mat3d& matrix, int dimensions) {
    const double size = matrix.trace();
    if (!(size > 0) || !std::isfinite(size)) return Mat3d::Zero();
    const Mat3d A = matrix / size;
    // With trace 1 and s_min/s_max = 0.04 the determinant is at most 0.0047 (2D: 0.037). If it is larger, all eigenvectors have weight 1.
    if (determinant_in(dimensions, A) > (dimensions == 3 ? 0.005 : 0.038)) return inverse_in(dimensions, A) / size;
    Eigen::SelfAdjointEigenSolver<Mat3d> eigen;
    eigen.computeDirect(A);
    const Vec3d s = eigen.eigenvalues();
    Vec3d inverse;
    for (int a = 0; a < 3; ++a) {
        const double relative = s[a] / s[2];
        const double t = relative > 0 ? std::clamp(std::log(relative / 0.01) / std::log(0.04 / 0.01), 0.0, 1.0) : 0;
        inverse[a] = t > 0 ? t * t * (3 - 2 * t) / s[a] : 0;
    }
    const Mat3d Q = eigen.eigenvectors();
    return Q * inverse.asDiagonal() * Q.transpose() / size;
}

}  // namespace whorl

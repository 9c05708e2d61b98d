#include "engine/sph/correction.h"

#include <Eigen/Eigenvalues>

#include "engine/core/parallel.h"
#include "engine/math/inverse_in.h"

namespace whorl {

Mat3d pseudo_inverse(const Mat3d& matrix, int dimensions) {
    const double size = matrix.trace();
    if (!(size > 0) || !std::isfinite(size)) return Mat3d::Zero();
    const Mat3d A = matrix / size;
    // With trace 1 and s_min/s_max = 0.04 the determinant is 0.0047 at most, in the plane 0.037: above that no direction is near the step.
    if (determinant_in(dimensions, A) > (dimensions == 3 ? 0.005 : 0.038)) return inverse_in(dimensions, A) / size;
    Eigen::SelfAdjointEigenSolver<Mat3d> eigen;
    eigen.computeDirect(A);
    const Vec3d s = eigen.eigenvalues();
    Vec3d inverse;
    for (int a = 0; a < 3; ++a) {
        const double relative = s[a] / s[2];
        const double t =
            relative > 0 ? std::clamp(std::log(relative / 0.01) / std::log(0.04 / 0.01), 0.0, 1.0)
                         : 0;
        inverse[a] = t > 0 ? t * t * (3 - 2 * t) / s[a] : 0;
    }
    const Mat3d Q = eigen.eigenvectors();
    return Q * inverse.asDiagonal() * Q.transpose() / size;
}

void sum_correction(const Pairs& pairs, KernelForm kernel, Real support, Span<const Real> V, Span<Mat3> L) {
    with_kernel(kernel, support, [&](const auto& W) {
        parallel_for(pairs.size(), [&](Index i) {
            // grad W_ij (x_j - x_i)^T = -W'/|r| r r^T: symmetric, six sums.
            Real xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
            pairs.groups_of(i, [&](const Pairs::Group& group) {
                Real volume[Pairs::Group::most];
                group.gather(V.data(), volume);
                for (Index l = 0; l < group.padded(); ++l) {
                    const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l], distance = group.distance[l];
                    const Real w = -volume[l] * W.slope(distance);
                    xx += w * x * x;
                    xy += w * x * y;
                    xz += w * x * z;
                    yy += w * y * y;
                    yz += w * y * z;
                    zz += w * z * z;
                }
            });
            Mat3d M;
            M << xx, xy, xz, xy, yy, yz, xz, yz, zz;
            L[i] = pseudo_inverse(M, kernel.dimensions).cast<Real>();
        });
    });
}

}  // namespace whorl

#include "engine/models/viscosity/strain/moment.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "engine/math/inverse_in.h"

namespace whorl {
namespace {

double resolved_part(double ratio) {
    return ratio <= 0 ? 0 : smooth_step(std::log(ratio / unresolved_at) / std::log(resolved_above / unresolved_at));
}

}  // namespace

Moment invert_moment(const Vec3d& s, const Mat3d& Q, int dimensions) {
    Moment m;
    m.unresolved = dimensions - 3;
    Vec3d pi, inverse;
    for (int a = 0; a < 3; ++a) {
        pi[a] = resolved_part(s[a] / s[2]);
        inverse[a] = pi[a] > 0 ? pi[a] / s[a] : 0;
        m.unresolved += 1 - pi[a] * pi[a];
    }
    m.inverse = Q * inverse.asDiagonal() * Q.transpose();
    m.resolved = Q * pi.asDiagonal() * Q.transpose();
    m.whole = m.unresolved == 0;
    return m;
}

Moment invert_moment(const Mat3d& M, int dimensions) {
    const double size = M.trace();
    if (!(size > 0)) return {.unresolved = static_cast<double>(dimensions)};
    // With trace 1 and s_min/s_max = 0.04 the determinant is 0.0047 at most, in 2D 0.037.
    if (const Mat3d scaled = M / size; determinant_in(dimensions, scaled) > (dimensions == 3 ? 0.005 : 0.038))
        return {inverse_in(dimensions, scaled) / size, Mat3d::Identity(), 0, true};
    const Eigen::SelfAdjointEigenSolver<Mat3d> axes(M);
    return invert_moment(axes.eigenvalues(), axes.eigenvectors(), dimensions);
}

}  // namespace whorl

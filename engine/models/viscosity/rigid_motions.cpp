#include "engine/models/viscosity/rigid_motions.h"

#include <Eigen/Eigenvalues>

#include "engine/core/parallel.h"

namespace whorl {

RigidMotions::RigidMotions(Span<const Vec3> x, bool turning) : x_(x) {
    const auto n = static_cast<Index>(x.size());
    if (n == 0) return;
    centre_ = parallel_sum(n, Vec3d(Vec3d::Zero()), [&](Index i) { return Vec3d(x[static_cast<std::size_t>(i)].cast<double>()); }) / n;
    if (!turning) return;
    const Mat3d inertia = parallel_sum(n, Mat3d(Mat3d::Zero()), [&](Index i) {
        const Vec3d r = x[static_cast<std::size_t>(i)].cast<double>() - centre_;
        return Mat3d(r.squaredNorm() * Mat3d::Identity() - r * r.transpose());
    });
    const Eigen::SelfAdjointEigenSolver<Mat3d> axes(inertia);
    const double largest = axes.eigenvalues()[2];
    for (int a = 0; a < 3; ++a)
        if (axes.eigenvalues()[a] > 1e-9 * largest && largest > 0)
            inverse_inertia_ += axes.eigenvectors().col(a) * axes.eigenvectors().col(a).transpose() / axes.eigenvalues()[a];
}

void RigidMotions::remove(Span<Vec3> u) const {
    const auto n = static_cast<Index>(x_.size());
    if (n == 0) return;
    struct Motion {
        Vec3d momentum = Vec3d::Zero(), spin = Vec3d::Zero();
        Motion& operator+=(const Motion& other) {
            momentum += other.momentum, spin += other.spin;
            return *this;
        }
    };
    const Motion sum = parallel_sum(n, Motion{}, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        const Vec3d v = u[k].cast<double>();
        return Motion{v, (x_[k].cast<double>() - centre_).cross(v)};
    });
    const Vec3d mean = sum.momentum / n, turn = inverse_inertia_ * sum.spin;
    parallel_for(n, [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        u[k] -= (mean + turn.cross(x_[k].cast<double>() - centre_)).cast<Real>();
    });
}

}  // namespace whorl

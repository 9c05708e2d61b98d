#include <Eigen/Eigenvalues>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/implicit_viscosity.h"

namespace whorl {

Momenta momenta_of(Span<const Vec3> x, Span<const Vec3> u, const Vec3d& centre) {
    return parallel_sum(static_cast<Index>(x.size()), Momenta{}, [&](Index i) {
        const Vec3d v = u[i].cast<double>();
        return Momenta{v, (x[i].cast<double>() - centre).cross(v)};
    });
}

RigidMotions::RigidMotions(Span<const Vec3> x, bool turning, const ViscousBodies* bodies) : x_(x), bodies_(bodies) {
    const auto n = static_cast<Index>(x.size());
    if (n == 0) return;
    mass_ = n;
    centre_ = parallel_sum(n, Vec3d(Vec3d::Zero()), [&](Index i) { return Vec3d(x[i].cast<double>()); });
    if (bodies_)
        for (const auto& b : bodies_->body) mass_ += b.mass, centre_ += b.mass * b.centre;
    centre_ /= mass_;
    if (!turning) return;
    const auto of_point = [&](const Vec3d& r) { return Mat3d(r.squaredNorm() * Mat3d::Identity() - r * r.transpose()); };
    Mat3d inertia = parallel_sum(n, Mat3d(Mat3d::Zero()), [&](Index i) { return of_point(x[i].cast<double>() - centre_); });
    if (bodies_)
        for (const auto& b : bodies_->body) inertia += b.turning + b.mass * of_point(b.centre - centre_);
    const Eigen::SelfAdjointEigenSolver<Mat3d> axes(inertia);
    const double largest = axes.eigenvalues()[2];
    for (int a = 0; a < 3; ++a)
        if (axes.eigenvalues()[a] > 1e-9 * largest && largest > 0)
            inverse_inertia_ += axes.eigenvectors().col(a) * axes.eigenvectors().col(a).transpose() / axes.eigenvalues()[a];
}

/// Momentum and angular momentum. @param masses the bodies' entries are velocities, which their masses weigh; else they are forces and
/// torques
Momenta RigidMotions::sum(Span<const Vec3> u, bool masses) const {
    Momenta all = momenta_of(x_, u, centre_);
    if (bodies_)
        for (std::size_t b = 0; b < bodies_->body.size(); ++b) {
            const auto& body = bodies_->body[b];
            Vec3d p = u[x_.size() + 2 * b].cast<double>(), spin = u[x_.size() + 2 * b + 1].cast<double>();
            if (masses) p = body.mass * p, spin = body.turning * spin;
            all += Momenta{p, spin + (body.centre - centre_).cross(p)};
        }
    return all;
}

void RigidMotions::add(Span<Vec3> u, const Momenta& momenta, bool masses) const {
    if (x_.empty()) return;
    const Vec3d mean = momenta.momentum / mass_, turn = inverse_inertia_ * momenta.turning;
    parallel_for(static_cast<Index>(x_.size()), [&](Index i) { u[i] += (mean + turn.cross(x_[i].cast<double>() - centre_)).cast<Real>(); });
    if (bodies_)
        for (std::size_t b = 0; b < bodies_->body.size(); ++b) {
            const auto& body = bodies_->body[b];
            const Vec3d v = mean + turn.cross(body.centre - centre_);
            u[x_.size() + 2 * b] += (masses ? v : Vec3d(body.mass * v)).cast<Real>();
            u[x_.size() + 2 * b + 1] += (masses ? turn : Vec3d(body.turning * turn)).cast<Real>();
        }
}

void RigidMotions::remove(Span<Vec3> u) const { add(u, -sum(u, true), true); }

void RigidMotions::remove_force(Span<Vec3> f) const { add(f, -sum(f, false), false); }

void RigidMotions::add(Span<const Vec3> v, Span<Vec3> u) const { add(u, sum(v, true), true); }

void RigidMotions::add(const Momenta& momenta, Span<Vec3> u) const {
    add(u, {momenta.momentum, momenta.turning - centre_.cross(momenta.momentum)}, true);
}

}  // namespace whorl

#include "engine/models/viscosity/implicit_viscosity.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "engine/core/parallel.h"
#include "engine/math/bicgstab.h"
#include "engine/models/bodies/reaction.h"

namespace whorl {
namespace {

/// sqrt(b.B^-1 b) of the right-hand side b: u* relative to its mean, and the loads of walls and nozzles.
double reference_size(const ImplicitOperator& A, const ImplicitStep& s, Span<const Vec3> u, bool alone, double prescribed) {
    const Index n = s.u.size();
    const std::size_t all = u.size();
    const Vec3d sum =
        parallel_sum(n, Vec3d(Vec3d::Zero()), [&](Index i) { return s.role[i] == 0 ? Vec3d(s.u[i].cast<double>()) : Vec3d::Zero(); });
    const Vec3 mean = (sum / std::max(1.0, n - prescribed)).cast<Real>();
    Column<Vec3> reference(all, Vec3::Zero()), z(all), still(all, Vec3::Zero());
    for (std::size_t k = static_cast<std::size_t>(n); k < all; k += 2) still[k] = mean;
    if (!alone) {
        parallel_for(n, [&](Index i) { still[i] = s.role[i] == 0 ? mean : s.u[i]; });
        A.force(still, reference);
    }
    parallel_for(n, [&](Index i) {
        const Vec3 walls = alone ? Vec3(Vec3::Zero()) : Vec3(mean - reference[i]);
        reference[i] = s.role[i] == 0 ? Vec3(s.u[i] - mean + walls) : Vec3(Vec3::Zero());
    });
    if (all > static_cast<std::size_t>(n)) {  // entries of the bodies: M (u - mean), and the loads of walls
        Column<Vec3> apart(all - static_cast<std::size_t>(n)), still_weighed(all - static_cast<std::size_t>(n)),
            weighed(all - static_cast<std::size_t>(n));
        for (std::size_t k = 0; k < apart.size(); ++k) apart[k] = u[n + k] - still[n + k];
        A.bodies()->weigh(apart, weighed);
        A.bodies()->weigh(Span<const Vec3>(still).subspan(n), still_weighed);
        for (std::size_t k = 0; k < apart.size(); ++k)
            reference[n + k] = weighed[k] + (alone ? Vec3(Vec3::Zero()) : Vec3(still_weighed[k] - reference[n + k]));
    }
    A.divide_by_diagonal(reference, z);
    return std::sqrt(dot<Vec3>(Span<const Vec3>(reference), Span<const Vec3>(z)));
}

/// Factor on the tolerance: 1 if viscosity changed the velocities by a hundredth or more in the last step, otherwise proportional to the
/// change, because errors of short steps add up. A factor below 0.03 would be near round-off.
double share_of_tolerance(const ImplicitStep& s, Span<const Vec3> last_change) {
    struct Sums {
        Vec3d u = Vec3d::Zero();
        double square = 0, change = 0;
        void operator+=(const Sums& o) { u += o.u, square += o.square, change += o.change; }
    };
    const Index n = s.u.size();
    const Sums sums = parallel_sum(n, Sums{}, [&](Index i) {
        const Vec3d u = s.u[i].cast<double>();
        return s.role[i] == 0 ? Sums{u, u.squaredNorm(), last_change[i].cast<double>().squaredNorm()} : Sums{};
    });
    const double apart = std::max(0.0, sums.square - sums.u.squaredNorm() / std::max<Index>(1, n));
    return std::clamp(apart > 0 ? 100 * std::sqrt(sums.change / apart) : 1, 0.03, 1.0);
}

}  // namespace

ImplicitSolution find_solution(const ImplicitOperator& A, const SolveLimits& limits, const ImplicitStep& s) {
    const Index n = s.u.size();
    const double prescribed = parallel_sum(n, [&](Index i) { return s.role[i] != 0; });
    const bool alone = !A.touches_wall() && prescribed == 0;
    const bool turning = A.rotations_are_free() && !s.context.step.domain.any_periodic();
    const ViscousBodies* bodies = A.bodies();
    const std::size_t all = static_cast<std::size_t>(n) + (bodies ? static_cast<std::size_t>(bodies->entries()) : 0);
    const RigidMotions rigid = alone ? RigidMotions(s.x.values, turning, bodies) : RigidMotions();
    Column<Vec3> u(all);
    std::copy(s.u.values.begin(), s.u.values.end(), u.begin());
    if (bodies) bodies->read(s.context.solids, Span<Vec3>(u).subspan(n));

    // The first guess must not add momentum. It could contain the last step's force of a wall that the fluid has left.
    Column<Vec3> change(all, Vec3::Zero()), guess(all), b(all), z(all, Vec3::Zero());
    parallel_for(n, [&](Index i) { change[i] = s.role[i] == 0 ? Vec3(s.context.step.dt * s.last[i]) : Vec3(Vec3::Zero()); });
    rigid.remove(change);
    parallel_for(static_cast<Index>(all), [&](Index i) { guess[i] = u[i] + change[i]; });
    A.force(guess, b);
    parallel_for(n, [&](Index i) { b[i] = s.role[i] == 0 ? Vec3(s.u[i] - b[i]) : Vec3(Vec3::Zero()); });
    if (bodies) {
        Column<Vec3> momentum(all - static_cast<std::size_t>(n));
        bodies->weigh(Span<const Vec3>(u).subspan(n), momentum);
        for (std::size_t k = 0; k < momentum.size(); ++k) b[n + k] = momentum[k] - b[n + k];
    }

    SolveReport solved;
    solved.converged = true;
    if (const double size = reference_size(A, s, u, alone, prescribed); size != 0) {  // NaN also enters, and the solve fails
        Column<Vec3> projected(all);
        const auto product = [&](Span<const Vec3> in, Span<Vec3> out) { A.multiply(in, out); };
        const auto precondition = [&](Span<const Vec3> r, Span<Vec3> out) {
            if (!alone) return A.precondition(r, out);
            std::copy(r.begin(), r.end(), projected.begin());
            rigid.remove_force(projected);
            A.precondition(projected, out);
            rigid.remove(out);
        };
        const SolveLimits of_step{share_of_tolerance(s, change) * limits.tolerance, limits.max_iterations};
        solved = A.symmetric() ? conjugate_gradients<Vec3>(product, precondition, Span<const Vec3>(b), Span<Vec3>(z), of_step,
                                                           ResidualNorm::preconditioned, size)
                               : bicgstab<Vec3>(product, precondition, Span<Vec3>(b), Span<Vec3>(z), of_step, size);
        parallel_for(static_cast<Index>(all), [&](Index i) { change[i] += z[i]; });
    }
    s.report.solves.push_back({SolveKind::viscosity, solved});
    parallel_for(n, [&](Index i) { s.last[i] = s.context.step.dt > 0 ? Vec3(change[i] / s.context.step.dt) : Vec3(Vec3::Zero()); });
    parallel_for(static_cast<Index>(all), [&](Index i) { u[i] += change[i]; });
    return {std::move(u), std::move(change)};
}

void take_solution(const ImplicitOperator& A, const ImplicitStep& s, const ImplicitSolution& solution) {
    const Index n = s.u.size();
    const Column<Vec3>&u = solution.u, &change = solution.change;
    const ViscousBodies* bodies = A.bodies();
    std::copy(u.begin(), u.begin() + n, s.u.values.begin());
    const Remainder rest(s.context.solids, Push::viscous);
    if (bodies) bodies->add_change(Span<const Vec3>(change).subspan(n), s.context.solids);
    if (!s.context.solids.any_probed()) return;
    // The solve minimised E. So (dE/du)/m, which contains the forces of solids and prescribed particles, differs from 0 by the residual.
    Column<Vec3> z(u.size());
    A.force(u, z);
    A.write_ledgers(s, u);
    Wrench residual = momentum_of(s.role, s.x.values, [&](Index i) { return Vec3(z[i] - (u[i] - change[i])); });
    if (bodies)
        residual += bodies->residual(Span<const Vec3>(z).subspan(n), Span<const Vec3>(u).subspan(n), Span<const Vec3>(change).subspan(n));
    rest.share(s.context.solids, s.context.step, -static_cast<double>(s.context.step.mass) * residual);
}

void BlockDiagonal::set(Column<Mat3> B, std::vector<char> free) {
    inverse_ = std::move(B);
    free_ = std::move(free);
    parallel_for(static_cast<Index>(inverse_.size()), [&](Index i) { inverse_[i] = inverse_[i].inverse().eval(); });
}

void BlockDiagonal::apply(Span<const Vec3> r, Span<Vec3> z) const {
    parallel_for(static_cast<Index>(inverse_.size()), [&](Index i) { z[i] = free_[i] ? Vec3(inverse_[i] * r[i]) : Vec3(Vec3::Zero()); });
}

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

/// Momentum and angular momentum. @param masses true: the bodies' entries are velocities, which must be multiplied by the bodies' masses;
/// false: the entries are forces and torques
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

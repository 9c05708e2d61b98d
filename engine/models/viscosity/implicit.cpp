#include "engine/models/viscosity/implicit.h"

#include <Eigen/LU>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/viscosity/rigid_motions.h"

namespace whorl {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// sqrt(b.B^-1 b) of the right-hand side b: u* relative to its mean, and what walls and nozzles bring in.
double reference_size(const ImplicitOperator& A, const ImplicitStep& s, bool alone, double prescribed) {
    const Index n = s.u.size();
    const Vec3d sum = parallel_sum(n, Vec3d(Vec3d::Zero()), [&](Index i) { return s.role[i] == 0 ? Vec3d(s.u[i].cast<double>()) : Vec3d::Zero(); });
    const Vec3 mean = (sum / std::max(1.0, n - prescribed)).cast<Real>();
    Column<Vec3> reference(at(n)), z(at(n));
    if (!alone) {
        Column<Vec3> still(at(n));
        parallel_for(n, [&](Index i) { still[at(i)] = s.role[i] == 0 ? mean : s.u[i]; });
        A.force(still, reference);
    }
    parallel_for(n, [&](Index i) {
        const Vec3 walls = alone ? Vec3(Vec3::Zero()) : Vec3(mean - reference[at(i)]);
        reference[at(i)] = s.role[i] == 0 ? Vec3(s.u[i] - mean + walls) : Vec3(Vec3::Zero());
    });
    A.divide_by_diagonal(reference, z);
    return std::sqrt(dot<Vec3>(Span<const Vec3>(reference), Span<const Vec3>(z)));
}

}  // namespace

void solve_implicit(const ImplicitOperator& A, const SolveLimits& limits, const ImplicitStep& s) {
    const Index n = s.u.size();
    const double prescribed = parallel_sum(n, [&](Index i) { return s.role[i] != 0; });
    const bool alone = !A.touches_wall() && prescribed == 0;
    const bool turning = A.rotations_are_free() && !s.step.domain.any_periodic();
    const RigidMotions rigid = alone ? RigidMotions(s.x.values, turning) : RigidMotions();

    // The first guess may not bring momentum from outside: a force of the last step by a wall that is not in touch any more.
    Column<Vec3> change(at(n)), guess(at(n)), b(at(n)), z(at(n), Vec3::Zero());
    parallel_for(n, [&](Index i) { change[at(i)] = s.role[i] == 0 ? Vec3(s.step.dt * s.last[i]) : Vec3(Vec3::Zero()); });
    rigid.remove(change);
    parallel_for(n, [&](Index i) { guess[at(i)] = s.u[i] + change[at(i)]; });
    A.force(guess, b);
    parallel_for(n, [&](Index i) { b[at(i)] = s.role[i] == 0 ? Vec3(s.u[i] - b[at(i)]) : Vec3(Vec3::Zero()); });

    SolveReport solved;
    solved.converged = true;
    if (const double size = reference_size(A, s, alone, prescribed); size > 0) {
        Column<Vec3> projected(at(n));
        const auto product = [&](Span<const Vec3> in, Span<Vec3> out) { A.multiply(in, out); };
        const auto precondition = [&](Span<const Vec3> r, Span<Vec3> out) {
            if (!alone) return A.precondition(r, out);
            std::copy(r.begin(), r.end(), projected.begin());
            rigid.remove(projected);
            A.precondition(projected, out);
            rigid.remove(out);
        };
        solved = conjugate_gradients<Vec3>(product, precondition, Span<const Vec3>(b), Span<Vec3>(z), limits, ResidualNorm::preconditioned, size);
        parallel_for(n, [&](Index i) { change[at(i)] += z[at(i)]; });
    }
    s.report.solves.push_back({"viscosity", solved});
    parallel_for(n, [&](Index i) {
        s.last[i] = s.step.dt > 0 ? Vec3(change[at(i)] / s.step.dt) : Vec3(Vec3::Zero());
        s.u[i] += change[at(i)];
    });
}

void BlockDiagonal::set(Column<Mat3> B, std::vector<char> free) {
    inverse_ = std::move(B);
    free_ = std::move(free);
    parallel_for(static_cast<Index>(inverse_.size()), [&](Index i) { inverse_[at(i)] = inverse_[at(i)].inverse().eval(); });
}

void BlockDiagonal::apply(Span<const Vec3> r, Span<Vec3> z) const {
    parallel_for(static_cast<Index>(inverse_.size()),
                 [&](Index i) { z[at(i)] = free_[at(i)] ? Vec3(inverse_[at(i)] * r[at(i)]) : Vec3(Vec3::Zero()); });
}

}  // namespace whorl

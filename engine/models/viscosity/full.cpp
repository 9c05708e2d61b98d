#include "engine/models/viscosity/full.h"

#include "engine/math/conjugate_gradients.h"
#include "engine/models/viscosity/rigid_motions.h"

namespace whorl {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

void FullViscosity::operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                               const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x, Read<field::viscosity> mu,
                               Update<field::velocity> u, Update<field::viscous_acceleration> last) {
    const Index n = u.size();
    ViscousOperator& A = operator_;
    A.set_up(options_, pairs, solid_pairs, solids, layer, step, role, mu);

    const double prescribed = parallel_sum(n, [&](Index i) { return role[i] != 0; });
    const bool alone = !A.touches_wall() && prescribed == 0;
    const RigidMotions rigid = alone ? RigidMotions(x.values, !step.domain.any_periodic()) : RigidMotions();

    // The first guess may not bring momentum from outside: a force of the last step by a wall that is not in touch any more.
    Column<Vec3> change(at(n)), guess(at(n)), b(at(n)), reference(at(n));
    parallel_for(n, [&](Index i) { change[at(i)] = role[i] == 0 ? Vec3(step.dt * last[i]) : Vec3::Zero(); });
    rigid.remove(change);
    parallel_for(n, [&](Index i) { guess[at(i)] = u[i] + change[at(i)]; });
    A.force(guess, b);
    parallel_for(n, [&](Index i) { b[at(i)] = role[i] == 0 ? Vec3(u[i] - b[at(i)]) : Vec3::Zero(); });

    // What the residual is measured against: the right-hand side, u* relative to its mean and what walls and nozzles bring in.
    const Vec3d mean = parallel_sum(n, Vec3d(Vec3d::Zero()), [&](Index i) { return role[i] == 0 ? Vec3d(u[i].cast<double>()) : Vec3d::Zero(); }) /
                       std::max(1.0, n - prescribed);
    if (!alone) {
        Column<Vec3> still(at(n));
        parallel_for(n, [&](Index i) { still[at(i)] = role[i] == 0 ? Vec3(mean.cast<Real>()) : u[i]; });
        A.force(still, reference);
    }
    parallel_for(n, [&](Index i) {
        const Vec3 walls = alone ? Vec3::Zero() : Vec3(mean.cast<Real>() - reference[at(i)]);
        reference[at(i)] = role[i] == 0 ? Vec3(u[i] - mean.cast<Real>() + walls) : Vec3::Zero();
    });
    Column<Vec3> z(at(n));
    A.precondition(reference, z);
    const double size = std::sqrt(dot<Vec3>(Span<const Vec3>(reference), Span<const Vec3>(z)));

    SolveReport solved;
    solved.converged = true;
    if (size > 0) {
        Column<Vec3> projected(at(n));
        const auto product = [&](Span<const Vec3> in, Span<Vec3> out) { A.multiply(in, out); };
        const auto precondition = [&](Span<const Vec3> r, Span<Vec3> out) {
            if (!alone) return A.precondition(r, out);
            std::copy(r.begin(), r.end(), projected.begin());
            rigid.remove(projected);
            A.precondition(projected, out);
            rigid.remove(out);
        };
        std::fill(z.begin(), z.end(), Vec3::Zero());
        solved = conjugate_gradients<Vec3>(product, precondition, Span<const Vec3>(b), Span<Vec3>(z), options_.limits, ResidualNorm::preconditioned, size);
        parallel_for(n, [&](Index i) { change[at(i)] += z[at(i)]; });
    }
    report.solves.push_back({"viscosity", solved});
    parallel_for(n, [&](Index i) {
        last[i] = step.dt > 0 ? Vec3(change[at(i)] / step.dt) : Vec3::Zero();
        u[i] += change[at(i)];
    });
}

}  // namespace whorl

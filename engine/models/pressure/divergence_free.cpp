#include "engine/models/pressure/divergence_free.h"

#include <cmath>

#include "engine/particles/largest_speed.h"

namespace whorl {
namespace {

/// Of the rest density: below it a particle is at the surface, or in spray, and nothing pulls.
constexpr Real near_full = Real(0.97);

}  // namespace

void DivergenceFree::operator()(const Surroundings& around, StepReport& report, Read<field::role> role, Write<field::density> rho,
                                Update<field::velocity> u, Update<field::pressure> p, Update<field::packing_pressure> s,
                                Write<field::drift> drift) {
    const StepContext& step = around.step;
    const Index n = rho.size();
    const Real rho_0 = step.rest_density;
    b_.resize(n), residual_.resize(n), rate_.resize(n), inside_.resize(n);
    const WallImage wall = wall_of(around);
    D_.build(wall, around, role, Read<field::velocity>{u.values}, rho.values, rate_);
    bodies_.build(wall, around, rho.values, D_);
    const bool filled = fills_periodic_domain(around, n);
    parallel_for(n, [&](Index i) {
        inside_[i] = filled || rho[i] > near_full * rho_0;
        b_[i] = rate_[i] + (inside_[i] ? 0 : std::min(Real(0), rho[i] - rho_0) / step.dt);
        p[i] = D_.diagonal[i] > 0 ? p[i] / D_.virial[i] * step.dt / (rho[i] * rho[i]) : 0;  // q
    });
    ConstraintMatrix matrix{D_, {}, Column<Padded>(n), around.pairs.x_own, step.spacing, bodies_.empty() ? nullptr : &bodies_};
    const auto mean_of = [&](const Column<Real>& values) {
        return parallel_sum(n, [&](Index i) { return static_cast<double>(values[i]); }) / n;
    };
    const auto fastest = static_cast<Real>(filled ? largest_speed(u.values) : 0);
    report.solves.push_back({"pressure", filled ? solve_filled(matrix, step, 0, 0, p.values) : solve(matrix, step, p.values, inside_)});
    bodies_.push(p.values, around.solids);
    matrix.presses.assign(n, 1);
    matrix.multiply(p.values, residual_);  // leaves D^T q in matrix.force
    const Real target = filled ? static_cast<Real>(parallel_sum(n, [&](Index i) { return static_cast<double>(rho[i]); }) / n) : rho_0;
    const Real time = correction_time(u.values, step);
    parallel_for(n, [&](Index i) {
        u[i] -= matrix.force[i].head<3>();
        p[i] *= D_.virial[i] * rho[i] * rho[i] / step.dt;
        b_[i] = rate_[i] - residual_[i] + correction_rate(rho[i], target, filled, step, time);
    });
    matrix.bodies = nullptr;
    report.solves.push_back(
        {"pressure", filled ? solve_filled(matrix, step, mean_of(b_), fastest, s.values) : solve(matrix, step, s.values)});
    D_.transposed(s.values, matrix.force);
    parallel_for(n, [&](Index i) { drift[i] = -matrix.force[i].head<3>(); });
}

}  // namespace whorl

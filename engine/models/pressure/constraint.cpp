#include "engine/models/pressure/constraint.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/bodies/reaction.h"
#include "engine/particles/step_context.h"

namespace whorl {
namespace {

/// Fraction of the tolerated density error that one step may leave; the next step corrects half of this error. In a dam break of ten layers
/// the fractions 0.1, 0.5 and 1 need 16.9, 11 and 8.1 iterations per step, and all leave a mean density error of 0.06 %.
constexpr double usual_share = 0.5;
/// The same fraction with free bodies, whose motion depends on few particles, and in full periodic domains, where the solve must not lose
/// energy.
constexpr double strict_share = 0.1;
/// Bound for residual/(right-hand side), in addition to the fractions above. In a short step gravity compresses less than these
/// fractions allow. A pressure solved to these fractions alone then jumps from step to step: in a column of 16 layers by 12 % of its mean
/// at CFL 0.4 and by 22 % at CFL 0.2. With this bound it jumps by 2.4 and 1.8 %. A tolerance looser than the default loosens the bound by
/// the same factor.
double largest_residual(double tolerance) { return 0.05 * std::max(1.0, tolerance / PressureOptions{}.limits.tolerance); }
/// Lower bounds for steps with hardly any load: fractions of the tolerated density error, and the tolerance that rounding allows.
constexpr double least_share = 0.005, least_with_bodies = 0.02, least_tolerance = 1e-6;

double changed(const std::vector<char>& before, const std::vector<char>& now) {
    return parallel_sum(static_cast<Index>(now.size()), [&](Index i) { return before[i] != now[i]; });
}

}  // namespace

PressurePreconditioner diagonal_scaling(const ConstraintMatrix& matrix) {
    return {[&matrix](Span<const Real> r, Span<Real> z) {
        parallel_for(matrix.size(), [&](Index i) { z[i] = matrix.presses[i] ? r[i] / matrix.D.diagonal[i] : 0; });
    }};
}

PressurePreconditioner constraint_unpreconditioned(const ConstraintMatrix&) { return {NoPreconditioner{}}; }

/// In such a domain no displacement lowers all densities together (the mean density is lowest on a lattice). Requesting this would tear the
/// fluid apart, with pressures that grow without bound.
bool fills_periodic_domain(const InteractionContext& context, Index n) {
    const StepContext& step = context.step;
    double volume = n * static_cast<double>(step.volume);
    for (const Solid& solid : context.solids.all)
        if (solid.body) volume += solid.body->volume;
    return step.domain.all_periodic() && volume > 0.98 * step.domain.volume();
}

/// Keeps the densities equal, so pressures have both signs. Solves A q = b minus the mean of b. This leaves a constant c in q undetermined,
/// with the force D^T c = c grad(sum rho). On a lattice c moves no particle. In other packings c orders the particles, which lowers the
/// mean density. c is the value that keeps the mean density from rising. It is at most the pressure that stops the fastest particle, for
/// which the time step is chosen, so c only removes energy.
SolveReport ConstraintPressure::solve_filled(ConstraintMatrix& matrix, const StepContext& step, double mean_rate, Real fastest,
                                             Span<Real> q) {
    const Index n = D_.size();
    const double start = wall_seconds(), worst_rate = std::sqrt(static_cast<double>(n)) * static_cast<double>(step.rest_density / step.dt);
    const auto without_mean = [&](Span<Real> values) {
        const double mean = parallel_sum(n, [&](Index i) { return matrix.presses[i] ? static_cast<double>(values[i]) : 0.0; }) / n;
        parallel_for(n, [&](Index i) { values[i] = matrix.presses[i] ? static_cast<Real>(values[i] - mean) : 0; });
    };
    matrix.presses.assign(n, 0);
    parallel_for(n, [&](Index i) { matrix.presses[i] = D_.diagonal[i] > std::numeric_limits<Real>::min(); });
    without_mean(b_);
    without_mean(q);
    const PressurePreconditioner M = preconditioner_(matrix);
    const double set_up = wall_seconds() - start;
    // Restricted to pressures with zero mean. Only then is the solve a projection, which cannot add energy.
    const auto A = [&](Span<const Real> in, Span<Real> out) { matrix.multiply(in, out), without_mean(out); };
    const auto precondition = [&](Span<const Real> r, Span<Real> z) { M(r, z), without_mean(z); };
    const SolveLimits limits{strict_share * options_.limits.tolerance, options_.limits.max_iterations};
    SolveReport report = conjugate_gradients<Real>(A, precondition, Span<const Real>(b_), q, limits, ResidualNorm::euclidean, worst_rate);
    Column<Real> ones(n, 1);
    D_.transposed(ones, matrix.force);
    const double ordering = parallel_sum(n, [&](Index i) { return static_cast<double>(matrix.force[i].squaredNorm()); }) / n;
    const double most = static_cast<double>(step.dt / step.rest_density * fastest * fastest / 2);
    const auto c = static_cast<Real>(ordering > 0 ? std::clamp(mean_rate / ordering, 0.0, most) : 0.0);
    parallel_for(n, [&](Index i) { q[i] += c; });
    report.levels = M.levels;
    report.set_up_seconds = set_up;
    report.solve_seconds = wall_seconds() - start - set_up;
    return report;
}

ConstraintPressure::ActiveSet ConstraintPressure::choose(ConstraintMatrix& matrix, Span<const Real> q, Real about_full,
                                                         Span<Real> rest) const {
    const Index n = D_.size();
    const auto can = [&](Index i) { return D_.diagonal[i] > std::numeric_limits<Real>::min(); };
    const ActiveSet set = parallel_sum(n, ActiveSet{}, [&](Index i) {
        const Real r = rest[i] = b_[i] - residual_[i];
        const bool pressed = q[i] > 0;
        matrix.presses[i] = can(i) && (pressed || r > 0);
        return matrix.presses[i] ? ActiveSet{static_cast<double>(r) * r, pressed, !pressed} : ActiveSet{};
    });
    const bool all = about_full > 0 && (set.joining > set.pressed);
    parallel_for(n, [&](Index i) {
        if (matrix.presses[i]) return;
        matrix.presses[i] = all && can(i) && rest[i] > -about_full;
        if (!matrix.presses[i]) rest[i] = 0;
    });
    return set;
}

/// Tolerated residual for the requested rates, as a fraction of worst_rate; see largest_residual().
double ConstraintPressure::tolerance_of_rates(const ConstraintMatrix& matrix, double worst_rate) const {
    const double asked =
        std::sqrt(parallel_sum(D_.size(), [&](Index i) { return matrix.presses[i] ? static_cast<double>(b_[i]) * b_[i] : 0.0; }));
    const double least = std::max((bodies_.empty() ? least_share : least_with_bodies) * options_.limits.tolerance, least_tolerance);
    return std::max(largest_residual(options_.limits.tolerance) * asked / worst_rate, least);
}

void ConstraintPressure::scale_to_work(ConstraintMatrix& matrix, Span<Real> q) {
    struct Sums {
        double asked = 0, done = 0;
        void operator+=(const Sums& o) { asked += o.asked, done += o.done; }
    };
    const Sums work = parallel_sum(D_.size(), Sums{}, [&](Index i) {
        return Sums{static_cast<double>(q[i]) * b_[i], static_cast<double>(q[i]) * residual_[i]};
    });
    if (!(work.done > 0)) return;
    const auto scale = static_cast<Real>(std::clamp(work.asked / work.done, 0.5, 2.0));
    parallel_for(D_.size(), [&](Index i) { q[i] *= scale, residual_[i] *= scale; });
    parallel_for(static_cast<Index>(matrix.force.size()), [&](Index i) { matrix.force[i] *= scale; });
}

/// Solve with an active set, the particles that are assumed to press. Conjugate gradients solve over this set. Then particles with a
/// negative pressure leave the set, particles that are still compressed join it, and the solve is repeated. The first set contains the
/// particles that pressed in the last step and those that are compressed now. If more than half of these are new (in the first step, in an
/// impact), particles with nearly full density join, too. Otherwise the set would grow by only two support radii per round. In other steps
/// this rule would include particles of the surface for a round, and a dam break would need 17.4 instead of 12.3 iterations per step.
SolveReport ConstraintPressure::solve(ConstraintMatrix& matrix, const StepContext& step, Span<Real> q) {
    constexpr Real about_full = Real(0.02);         // relative density that is missing
    constexpr double changes_to_set_up_for = 0.02;  // fraction of the particles
    const Index n = D_.size();
    const double worst_rate = std::sqrt(static_cast<double>(n)) * static_cast<double>(step.rest_density / step.dt);
    // A lattice has modes (neighbours alternately up and down) that no pressure moves. With a smaller tolerance these modes grow without
    // bound.
    const double share = bodies_.touched() ? strict_share : usual_share;
    double tolerance = share * options_.limits.tolerance;
    PressurePreconditioner M;
    std::vector<char> set_up_for;  // presses, when M was set up
    const auto A = [&](Span<const Real> in, Span<Real> out) { matrix.multiply(in, out); };
    Column<Real> rest(n);  // b - A q of the particles that press
    SolveReport report;
    const double start = wall_seconds();
    for (int round = 0;; ++round) {
        matrix.presses.assign(n, 1);
        if (round > 0) matrix.push(q);
        D_.apply(matrix.force, matrix.presses, residual_);
        if (bodies_.empty()) scale_to_work(matrix, q);
        else bodies_.add_rates(q, matrix.presses, residual_);
        const ActiveSet set = choose(matrix, q, round == 0 ? about_full * step.rest_density / step.dt : 0, rest);
        const double left = std::sqrt(set.squares);
        report.last_residual = left / worst_rate;
        if (round == 0) {
            report.first_residual = report.last_residual;
            tolerance = std::min(tolerance, tolerance_of_rates(matrix, worst_rate));
        }
        report.converged = report.last_residual <= tolerance;
        report.solve_seconds = wall_seconds() - start - report.set_up_seconds;
        if (report.converged) return report;
        if (!std::isfinite(left) || report.iterations >= options_.limits.max_iterations || round > options_.limits.max_iterations) {
            report.why_not = "the density error of the step is " + std::to_string(report.last_residual) + " after " +
                             std::to_string(report.iterations) + " iterations in " + std::to_string(round) + " rounds";
            return report;
        }
        if (set_up_for.empty() || changed(set_up_for, matrix.presses) > changes_to_set_up_for * n) {
            const double before = wall_seconds();
            M = preconditioner_(matrix);
            set_up_for = matrix.presses;
            report.levels = M.levels;
            report.set_up_seconds += wall_seconds() - before;
        }
        // Early rounds need not be exact, because their set changes.
        const double aim = std::max(tolerance / 2, report.last_residual / 10);
        const SolveLimits limits{aim, options_.limits.max_iterations - report.iterations};
        report.iterations +=
            conjugate_gradients_from<Real>(A, M, Span<Real>(rest), q, limits, ResidualNorm::euclidean, worst_rate).iterations;
        parallel_for(n, [&](Index i) { q[i] = std::max(Real(0), q[i]); });
    }
}

/// Whether the fluid has a free surface, judged by the last step's pressures. It has one if the pressure of at least n^(2/3)/10 particles
/// (a tenth of a cube's face) does not exceed the weight of a layer. Zero would be too strict, because in fluid at rest all particles
/// press, also those of the surface. Without a surface no displacement makes room for e > 0, and pressures would grow without bound. All
/// fluid is checked together, so an open pool hides a full vessel next to it.
bool ConstraintPressure::has_free_surface(Span<const Real> q, const StepContext& step) const {
    const auto n = static_cast<Index>(q.size());
    const Real layer = step.dt * step.gravity.norm() * step.spacing / step.rest_density;
    const double free = parallel_sum(n, [&](Index i) { return q[i] <= layer; });
    return free >= std::max(1.0, 0.1 * std::pow(static_cast<double>(n), 2.0 / 3));
}

bool ConstraintPressure::limit_level(Span<Real> q, const StepContext& step) {
    const auto n = static_cast<Index>(q.size());
    const Real most = step.spacing * step.spacing / (16 * step.rest_density * step.dt);  // does not shorten usual steps: pressure_step()
    const double mean = parallel_sum(n, [&](Index i) { return static_cast<double>(q[i]); }) / std::max(n, Index(1));
    // Without a surface no pressure is far below the mean, so low pressures reveal even a narrow opening.
    const double side = std::pow(n, 1 - 1.0 / step.dimensions()), low = parallel_sum(n, [&](Index i) { return q[i] < 0.1 * mean; });
    const double above = parallel_sum(n, [&](Index i) { return q[i] > most; });
    if (n == 0 || above < 0.95 * n || low >= std::max(1.0, 0.02 * side)) return false;
    parallel_for(n, [&](Index i) { q[i] = std::min(q[i], most); });
    return true;
}

Real ConstraintPressure::correction_time(Span<const Vec3> u, const StepContext& step) const {
    if (bodies_.empty()) return step.dt;
    const auto speed = static_cast<Real>(std::hypot(largest_speed(u), std::sqrt(static_cast<double>(step.gravity.norm() * step.spacing))));
    return speed > 0 ? std::max(step.dt, Real(0.4) * step.spacing / speed) : step.dt;
}

Real ConstraintPressure::correction_rate(Real rho, Real target, bool filled, bool at_body, const StepContext& step, Real time) const {
    // Compression by an impact counts as at most 5 % of the density, otherwise the fluid would jump. In full periodic domains the limit is
    // 0.5 %, because density errors that alternate from neighbour to neighbour need large velocities to be corrected.
    const Real rho_0 = step.rest_density;
    const Real excess = filled ? std::clamp(rho - target, -rho_0 / 200, rho_0 / 200) : std::min(rho - target, rho_0 / 20);
    // Small deficits of density, of the size that the solves leave, are corrected by the same share. If they were filled within a step,
    // particles would fall in one step and be stopped in the next one.
    const Real left = bodies_.empty() ? static_cast<Real>(0.1 * options_.limits.tolerance) * rho_0 : Real(0);
    const Real corrected = filled ? excess : std::max(excess, -left);
    return correction_share(filled || at_body) * corrected / time + (excess - corrected) / step.dt;
}

Real ConstraintPressure::calm_share(Span<const Real> rho, Span<const Vec3> u, const StepContext& step) const {
    constexpr Real full = Real(0.99);  // of rho_0: particles without a surface
    constexpr double slow = 0.03;
    struct Sums {
        double excess = 0, squares = 0;
        void operator+=(const Sums& o) { excess += o.excess, squares += o.squares; }
    };
    const double g = static_cast<double>(step.gravity.norm()), rho_0 = static_cast<double>(step.rest_density);
    const auto n = static_cast<Index>(rho.size());
    const Sums sums = parallel_sum(n, Sums{}, [&](Index i) {
        return Sums{rho[i] > full * step.rest_density ? static_cast<double>(rho[i]) - rho_0 : 0, static_cast<double>(u[i].squaredNorm())};
    });
    const double size = std::pow(n * static_cast<double>(step.volume), 1.0 / step.dimensions());
    const double most = slow * (std::sqrt(g * size) + std::sqrt(sums.squares / n)) / size;
    const double rate = correction() * sums.excess / (n * rho_0 * static_cast<double>(step.dt));
    return most > 0 && rate > most ? static_cast<Real>(most / rate) : Real(1);
}

void ConstraintPressure::add_bend(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, Span<const Vec3> u,
                                  Span<const Real> q, Span<const Padded> force) {
    constexpr Real most = Real(0.02);  // fraction of rho_0; a larger error means displacements beyond the linear range of the densities
    const StepContext& step = context.step;
    const Index n = D_.size();
    Column<Real> bend(static_cast<std::size_t>(n));
    Column<Vec3> expected(static_cast<std::size_t>(n));  // velocities after the step, by the last pressure
    parallel_for(n, [&](Index i) { expected[i] = u[i] - force[i].head<3>(); });
    D_.bend(wall, context, rho, expected, bodies_.poses_after(q, context.solids), bend);
    parallel_for(n, [&](Index i) { b_[i] += std::clamp(bend[i], -most * step.rest_density, most * step.rest_density) / step.dt; });
}

/// Warning about fluid that solids squeeze.
std::string ConstraintPressure::squeezed_text(const InteractionContext& context, Span<const Real> q) const {
    const StepContext& step = context.step;
    Eigen::AlignedBox3f box;
    for (Index i = 0; i < D_.size(); ++i)
        if (q[i] > 0) box.extend(context.pairs.x_own[i].cast<float>());
    return fmt::format(
        "fluid without room at {:.4g} s: solids squeeze the fluid that fills the space from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, "
        "{:.4g}, {:.4g}) m; {:.2g} m^{} are too much after this step",
        step.time, box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z(),
        parallel_sum(D_.size(), [&](Index i) { return q[i] > 0 ? static_cast<double>(b_[i]) : 0.0; }) *
            static_cast<double>(step.dt * step.volume / step.rest_density),
        step.dimensions());
}

void ConstraintPressure::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role,
                                    Write<field::density> rho, Update<field::velocity> u, Update<field::constraint_pressure> multiplier,
                                    Write<field::pressure> p) {
    const StepContext& step = context.step;
    const Index n = rho.size();
    const Real rho_0 = step.rest_density;
    const Span<Real> q = multiplier.values;
    b_.resize(n);
    residual_.resize(n);
    const WallImage wall(context, options_.gate);
    D_.build(wall, context, role, Read<field::velocity>{u.values}, rho.values, b_);
    bodies_.build(wall, context, rho.values, D_);
    const bool filled = fills_periodic_domain(context, n);
    const Real target = filled ? static_cast<Real>(parallel_sum(n, [&](Index i) { return static_cast<double>(rho[i]); }) / n) : rho_0;
    const double mean_rate = filled ? parallel_sum(n, [&](Index i) { return static_cast<double>(b_[i]); }) / n : 0;
    const Real time = correction_time(u.values, step),
               calm = filled || context.boundary.size() == 0 ? Real(1) : calm_share(rho.values, u.values, step);
    std::vector<char> at_bodies(static_cast<std::size_t>(n), 0);
    bodies_.mark(at_bodies);
    parallel_for(n, [&](Index i) {
        const Real rate = correction_rate(rho[i], target, filled, at_bodies[i], step, at_bodies[i] ? time : step.dt);
        b_[i] += rate > 0 ? calm * rate : rate;
        q[i] = D_.diagonal[i] > 0 ? q[i] / D_.virial[i] * step.dt / (rho[i] * rho[i]) : 0;
    });
    ConstraintMatrix matrix{D_, {}, Column<Padded>(D_.x.size()), context.pairs.x_own, step.spacing, bodies_.empty() ? nullptr : &bodies_};
    matrix.push(q);
    if (filled || has_free_surface(q, step)) add_bend(wall, context, rho.values, u.values, q, matrix.force);
    const auto fastest = static_cast<Real>(filled ? largest_speed(u.values) : 0);
    report.solves.push_back({SolveKind::pressure, filled ? solve_filled(matrix, step, mean_rate, fastest, q) : solve(matrix, step, q)});
    if (!filled && !has_free_surface(q, step) && limit_level(q, step)) {
        matrix.push(q);
        report.full = squeezed_text(context, q);
    }
    const auto& solids = context.solids.all;
    // Images in two walls with the same normal push a pair unequally.
    const bool unequal =
        D_.mirrors.size() > 0 && std::all_of(solids.begin(), solids.end(), [](const Solid& solid) { return solid.keeps_ledger(); });
    const Remainder rest = unequal ? Remainder(context.solids, Push::pressure) : Remainder();
    bodies_.push(q, context.solids);
    write_ledgers(wall, context, role, rho.values, q);
    if (unequal) share_rest(rest, context, role, context.pairs.x_own, [&](Index i) { return Vec3(-matrix.force[i].head<3>()); });
    if (step.to_frame_time) find_pressures(wall, context, rho.values, q, p.values);
    if (filled) matrix.push(q);  // solve() has already done so
    parallel_for(n, [&](Index i) {
        u[i] -= matrix.force[i].head<3>();
        q[i] *= D_.virial[i] * rho[i] * rho[i] / step.dt;
    });
    Column<Real>().swap(D_.slope);  // frees a fifth of a step's memory
}

double pressure_step(double cfl, double spacing, double rest_density, Span<const Real> pressure) {
    struct Sums {
        double p = 0, p2 = 0;
        void operator+=(const Sums& o) { p += o.p, p2 += o.p2; }
    };
    const Sums sums = parallel_sum(static_cast<Index>(pressure.size()), Sums{}, [&](Index i) {
        const double p = pressure[i];
        return Sums{std::abs(p), p * p};
    });
    if (!(sums.p2 > 0)) return std::numeric_limits<double>::infinity();
    // Mean weighted with p. In a column it is 2/3 of the pressure at the bottom. Single spikes of an impact have little weight.
    return cfl * spacing / std::sqrt(1.5 * sums.p2 / sums.p / rest_density);
}

}  // namespace whorl

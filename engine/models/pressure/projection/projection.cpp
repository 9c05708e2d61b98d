#include "engine/models/pressure/projection/projection.h"

#include <cmath>
#include <limits>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/math/inverse_in.h"
#include "engine/models/motion/fickian.h"
#include "engine/models/pressure/projection/difference_sums.h"

namespace whorl {

/// c_ij = V 2 V |W'|/r among the unknowns. Neighbours on the surface have the outside pressure, prescribed neighbours the pressure p_i.
template <class Kernel>
void Projection::build(const Kernel& W, const Fields& f) {
    const ProjectionSystem& s = *system_;
    const FluidPairs& pairs = f.context.pairs;
    const Index n = pairs.size();
    of_air_.assign(n, 0), touches_surface_.assign(n, 0);
    matrix_.unknown.resize(n);
    parallel_for(n, [&](Index i) { matrix_.unknown[i] = f.role[i] == 0 && !s.surface[i] && pairs.count(i) > 0; });
    matrix_.lay_out(pairs, f.step.spacing);
    const Real V = f.step.volume;
    // Gradients with a large L act on more than the sums of a particle with few neighbours contain. In narrow gaps the excess would make
    // each solve overshoot.
    Column<Real> excess(s.narrow ? n : 0);
    parallel_for(static_cast<Index>(excess.size()), [&](Index i) { excess[i] = std::max(Real(1), s.whole.correction[i].trace() / 2); });
    const bool all_unknown = std::all_of(matrix_.unknown.begin(), matrix_.unknown.end(), [](char unknown) { return unknown != 0; });
    parallel_for(n, [&](Index i) {
        if (!matrix_.unknown[i]) return;
        std::size_t k = pairs.first[i];
        Real row = 0, pin = V * s.air[i], of_air = pin * s.pressure_outside(i);
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real c[Pairs::Group::most];
            for (Index l = 0; l < group.padded(); ++l) c[l] = -2 * V * V * W.slope(group.distance[l]);
            if (s.narrow)
                for (Index l = 0; l < group.count; ++l) c[l] *= (excess[i] + excess[group.other[l]]) / 2;
            if (all_unknown) {
                std::copy(c, c + group.count, matrix_.c.data() + k);
                k += static_cast<std::size_t>(group.count);
                for (Index l = 0; l < group.padded(); ++l) row += c[l];
                return;
            }
            for (Index l = 0; l < group.count; ++l) {
                const Index j = group.other[l];
                matrix_.c[k++] = matrix_.unknown[j] ? c[l] : Real(0);
                if (matrix_.unknown[j]) row += c[l];
                else if (s.surface[j]) pin += c[l], of_air += c[l] * s.pressure_outside(j), touches_surface_[i] = 1;
            }
        });
        matrix_.pin[i] = pin, of_air_[i] = of_air;
        matrix_.diagonal[i] = std::max(row + pin, min_positive);
    });
}

void Projection::find_held(const Fields& f) {
    const Read<field::role> role = f.role;
    beside_held_.assign(role.size(), 0);
    if (parallel_sum(role.size(), [&](Index i) { return role[i] != 0 ? 1 : 0; }) == 0) return;
    parallel_for(role.size(),
                 [&](Index i) { f.context.pairs.of(i, [&](Index j, const Vec3&, Real) { beside_held_[i] |= role[j] != 0; }); });
}

template <class Kernel>
void Projection::set_source(const Kernel& W, const Fields& f, Real dt) {
    const ProjectionSystem& s = *system_;
    const StepContext& step = f.step;
    const InteractionContext& context = f.context;
    const Vec3* const u = f.u.data();
    parallel_for(s.size(), [&](Index i) {
        b_[i] = 0;
        if (!matrix_.unknown[i]) return;
        const Mat3 G = difference_sum(W, context.pairs, i, step.volume, u) * s.whole.correction[i];
        Real divergence = s.narrow ? s.of_gradient[i].cwiseProduct(G).sum() : G.trace();
        s.walls_of(i, [&](const WallTouch& touch) {
            const Vec3& normal = context.boundary.normal[touch.s];
            const Real at_wall =
                (u[i] - context.boundary.velocity[touch.s]).dot(normal) - (s.narrow ? Real(0) : touch.height * normal.dot(G * normal));
            divergence -= touch.flux * at_wall;
        });
        b_[i] = -step.volume * step.rest_density / dt * divergence;
    });
}

/// Damps the part of the velocities that deviates from a linear flow, which no pressure resolves, between particles near the free surface,
/// or in a full room between particles near the edges of walls. Near a surface the rate is eight times the frequency of the shortest waves.
/// With half of it gaps in a stretching surface grow, and a steep slosh diverges. At edges the rate is that at which the fastest fluid
/// passes two spacings. Without it water that circulates in a closed box gains energy from the edges.
void Projection::damp_unresolved(const Fields& f) const {
    const ProjectionSystem& s = *system_;
    const auto& [context, step, role, u, p, solved, a] = f;
    if (s.options.free_surface ? !(s.shortest_waves(step) > 0) : !s.any_walls) return;
    const Real rate = s.options.free_surface
                          ? 8 * s.shortest_waves(step)
                          : std::sqrt(parallel_max(u.size(), 0, [&](Index i) { return u[i].squaredNorm(); })) / (2 * step.spacing);
    const Real share = std::min(Real(0.5), rate * step.dt) * step.volume;
    std::vector<Vec3> change(u.size(), Vec3::Zero());
    std::vector<Mat3> half_gradient(u.size(), Mat3::Zero());
    const std::vector<char>& damped = s.options.free_surface ? s.near_surface : s.near_edge;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(u.size(), [&](Index i) {
            if (damped[i]) half_gradient[i] = difference_sum(W, context.pairs, i, step.volume, u.data()) * s.whole.correction[i] / 2;
        });
        parallel_for(u.size(), [&](Index i) {
            if (!damped[i] || role[i] != 0) return;
            context.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
                if (damped[j] && role[j] == 0)
                    change[i] += share * W.value(distance) * (u[j] - u[i] + (half_gradient[i] + half_gradient[j]) * r);
            });
        });
    });
    parallel_for(u.size(), [&](Index i) { u[i] += change[i]; });
}

/// u -= share dt g, with g = grad p/rho of the last step. p starts with this share of the last pressure. Large g are dropped, because the
/// pressure of an impact must not act again in the next step.
void Projection::take_old_share(const Fields& f, Real share) {
    const auto& [context, step, role, u, p, solved, a] = f;
    const Real most = system_->most_carried(step);
    if (system_->expected) ExpectedOnBodies::forget(context);
    parallel_for(u.size(), [&](Index i) {
        const bool goes_on = role[i] == 0 && a[i].norm() < most;
        if (goes_on) u[i] -= (system_->expected ? share - 1 : share) * step.dt * a[i];
        phi_[i] = goes_on ? solved[i] : 0;
        p[i] = share * phi_[i];
        a[i].setZero();
    });
    on_bodies_.push(phi_, static_cast<double>(share * step.dt), context);
}

/// grad phi/rho_0 at i. Particles in a nozzle have no pressure; near them the gradient uses the free particles alone, as near walls.
template <class Kernel>
Vec3 Projection::push_of(const Kernel& W, const Fields& f, Index i) const {
    const InteractionContext& context = f.context;
    const StepContext& step = f.step;
    if (system_->options.bare_surface && (system_->surface[i] || touches_surface_[i])) {
        const Column<Mat3>& L = system_->whole.correction;
        Vec3 sum = Vec3::Zero();
        context.pairs.of(
            i, [&](Index j, const Vec3& r, Real distance) { sum += W.slope(distance) * ((phi_[i] * L[i] + phi_[j] * L[j]) * r); });
        return step.volume / step.rest_density * sum;
    }
    if (!beside_held_[i])
        return system_->whole.correction[i] * difference_sum(W, context.pairs, i, step.volume, phi_.data()) / step.rest_density;
    Mat3d moment = Mat3d::Zero();
    Vec3 sum = Vec3::Zero();
    context.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
        if (f.role[j] != 0) return;
        const Vec3 weight = step.volume * W.slope(distance) * r;
        sum += (phi_[j] - phi_[i]) * weight;
        moment -= weight.cast<double>() * r.cast<double>().transpose();
    });
    return pseudo_inverse(moment, step.dimensions()).template cast<Real>() * sum / step.rest_density;
}

/// One solve: adds to p and g for the remaining divergence of u.
/// @param M preconditioner of matrix_
template <class Kernel>
SolveReport Projection::solve(const Kernel& W, const PressurePreconditioner& M, const Fields& f, Real dt, bool first) {
    const ProjectionSystem& s = *system_;
    const auto& [context, step, role, u, p, solved, a] = f;
    const auto A = [&](Span<const Real> in, Span<Real> out) {
        matrix_.multiply(in, out);
        on_bodies_.add_product(in, out);
    };
    set_source(W, f, dt);
    if (first && !s.surface_pressure.empty()) parallel_for(u.size(), [&](Index i) { b_[i] += of_air_[i]; });
    closed_.subtract_means(b_);
    SolveLimits limits = s.options.limits;
    // With bodies the later solves keep the tolerance of the first, because a residual that is small for the fluid moves a light body.
    if (!first && !on_bodies_.any()) limits.tolerance = std::max(limits.tolerance, s.options.later_tolerance);
    parallel_for(u.size(), [&](Index i) { phi_[i] = first && matrix_.unknown[i] ? solved[i] : 0; });
    const double began = wall_seconds();
    SolveReport report = conjugate_gradients<Real>(A, M, Span<const Real>(b_), Span<Real>(phi_), limits);
    report.solve_seconds = wall_seconds() - began;
    closed_.subtract_means(phi_);
    if (first && !s.surface_pressure.empty())
        parallel_for(u.size(), [&](Index i) {
            if (s.surface[i]) phi_[i] = s.surface_pressure[i];
        });
    parallel_for(u.size(), [&](Index i) {
        solved[i] = (first ? Real(0) : solved[i]) + phi_[i];
        if (role[i] != 0) return;
        const Vec3 push = push_of(W, f, i);
        a[i] += push;
        u[i] -= dt * push;
    });
    on_bodies_.push(phi_, static_cast<double>(dt), context);
    return report;
}

const PressurePreconditioner& Projection::preconditioner(const StepContext& step) {
    const ProjectionOptions& options = system_->options;
    const bool keeps = !options.free_surface && !step.at_frame_time && kept_steps_ + 1 < kept_most && kept_for_ == matrix_.size();
    kept_steps_ = keeps ? kept_steps_ + 1 : 0;
    if (!keeps) kept_ = options.preconditioner(matrix_), kept_for_ = matrix_.size();
    return kept_;
}

void Projection::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Update<field::velocity> u,
                            Update<field::pressure> p, Update<field::solved_pressure> solved, Update<field::pressure_acceleration> a) {
    const ProjectionSystem& s = *system_;
    const StepContext& step = context.step;
    const Fields f{context, step, role, u, p, solved, a};
    const Index n = u.size();
    // In the first step there is no earlier pressure.
    const bool any_before = parallel_sum(n, [&](Index i) { return a[i] != Vec3::Zero() ? 1 : 0; }) > 0;
    const Real theta = any_before ? static_cast<Real>(s.options.theta) : Real(1);
    b_.resize(n), phi_.resize(n);
    SolveReport all;
    all.converged = true;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        const double start = wall_seconds();
        build(W, f);
        find_held(f);
        on_bodies_.build(s, context, role, matrix_.unknown);
        closed_.find(matrix_, touches_surface_, 0.01);
        closed_.take_pins_away(matrix_);
        const PressurePreconditioner& M = preconditioner(step);
        begin_ledgers(f);
        all.levels = M.levels;
        all.set_up_seconds = wall_seconds() - start;
        take_old_share(f, 1 - theta);
        damp_unresolved(f);
        for (int k = 0; k < s.options.solves; ++k) {
            const SolveReport one = solve(W, M, f, theta * step.dt, k == 0);
            all.solve_seconds += one.solve_seconds;
            all.iterations += one.iterations;
            if (k == 0) all.first_residual = one.first_residual, all.last_residual = one.last_residual;
            if (!one.converged) all.converged = false, all.why_not = one.why_not;
        }
    });
    parallel_for(n, [&](Index i) { p[i] += theta * solved[i]; });
    if (s.expected) ExpectedOnBodies::take(context);
    write_ledgers(f);
    Column<Real>().swap(matrix_.c);  // not needed until the next step, and as large as the weights of a viscous solve
    report.solves.push_back({SolveKind::pressure, all});
}

/// Records the velocities without any pressure. If ExpectPressure has applied the last step's pressure, the record excludes this pressure.
void Projection::begin_ledgers(const Fields& f) {
    ProjectionSystem& s = *system_;
    const auto& [context, step, role, u, p, solved, a] = f;
    s.before.clear();
    if (!context.solids.any_probed()) return;
    s.remainder = Remainder(context.solids, Push::pressure);
    s.before.assign(u.values.begin(), u.values.end());
    const Real most = s.most_carried(step);
    parallel_for(u.size(), [&](Index i) {
        if (s.expected && role[i] == 0 && a[i].norm() < most) s.before[i] += step.dt * a[i];
    });
}

/// A particle with the pressure p pushes each wall by V flux p n.
void Projection::write_ledgers(const Fields& f) {
    ProjectionSystem& s = *system_;
    const auto& [context, step, role, u, p, solved, a] = f;
    if (s.before.empty() || !s.any_walls) return;
    // The surface lies half a spacing above the particles that have its pressure.
    const Real above = s.options.free_surface ? step.rest_density * step.spacing / 2 : 0, g = step.gravity.norm();
    react(
        context, Push::pressure, role, step.volume * step.dt,
        [&](Index i) {
            return [&, i](Index q, const Vec3& r, Real) {
                const WallTouch* touch = &s.touches[s.first_touch[i]];
                while (touch->s != q) ++touch;
                const Vec3& n = context.boundary.normal[q];
                return PushAt(-(touch->flux * (p[i] + above * std::min(a[i].norm(), g))) * n, r - step.spacing / 2 * n);
            };
        },
        Writes::driven);
    s.closed = on_bodies_.write_closed(s, context, role, p.values);
}

/// Largest speed relative to the mean velocity [m/s], independent of the frame of reference.
Real max_speed_of(Span<const Vec3> u) {
    struct Sum {
        Vec3d sum = Vec3d::Zero();
        void operator+=(const Sum& o) { sum += o.sum; }
    };
    const auto n = static_cast<Index>(u.size());
    if (n == 0) return 0;
    const Vec3 mean = (parallel_sum(n, Sum{}, [&](Index i) { return Sum{u[i].cast<double>()}; }).sum / n).cast<Real>();
    return static_cast<Real>(std::sqrt(parallel_max(n, 0, [&](Index i) { return (u[i] - mean).squaredNorm(); })));
}

/// Moves particles that protrude from the surface back, which the pressure of the smoothed curvature does not do:
///   dx_i += .1 dt f n_i sum_j W (n_i + n_j)/2.(x_j - x_i)/sum W of a flat layer,   f the frequency of the shortest waves,
/// over particles on the surface. A term of the sum is 0 for two particles on a sphere, and opposite for i and j.
void ProjectionShift::level_surface(const InteractionContext& context, Read<field::role> role) const {
    ProjectionSystem& s = *system;
    const StepContext& step = context.step;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        Real layer = 0;
        each_lattice_point(step.dimensions() - 1, static_cast<int>(std::ceil(step.support / step.spacing)), [&](int a, int b, int) {
            if (a != 0 || b != 0) layer += W.value(step.spacing * std::sqrt(static_cast<Real>(a * a + b * b)));
        });
        const Real share = std::min(Real(0.5), Real(0.1) * step.dt * s.shortest_waves(step)) / layer, most = step.spacing / 10;
        parallel_for(s.size(), [&](Index i) {
            if (role[i] != 0 || !s.surface[i]) return;
            const Vec3 n = s.surface_normal[i];
            Real height = 0;
            context.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
                const Vec3& other = s.surface_normal[j];
                if (s.surface[j] && n.dot(other) > Real(0.5)) height -= W.value(distance) * (n + other).dot(r) / 2;
            });
            s.shift[i] += std::clamp(share * height, -most, most) * n;
        });
    });
}

namespace {

/// Removes the part of a change of velocity at i that would increase the velocity relative to the neighbours' mean, if that is more than
/// three times the neighbours' own scatter. Gradients that are extrapolated towards a wall would otherwise accelerate a single particle
/// beside the wall from step to step, the faster the faster it is.
template <class Kernel>
void limit_outlier(const Kernel& W, const FluidPairs& pairs, Index i, Span<const Vec3> u, Vec3& change) {
    Real weights = 0, square = 0;
    Vec3 sum = Vec3::Zero();
    pairs.of(i, [&](Index j, const Vec3&, Real distance) {
        const Real w = W.value(distance);
        weights += w, sum += w * (u[j] - u[i]), square += w * (u[j] - u[i]).squaredNorm();
    });
    if (!(weights > 0)) return;
    const Vec3 ahead = -sum / weights;
    const Real apart = ahead.squaredNorm(), more = change.dot(ahead);
    if (more > 0 && apart > 9 * (square / weights - apart)) change -= more / apart * ahead;
}

}  // namespace

void ProjectionShift::operator()(const InteractionContext& context, Read<field::role> role, Update<field::position> x,
                                 Update<field::velocity> u) const {
    ProjectionSystem& s = *system;
    const StepContext& step = context.step;
    const Index n = u.size();
    const Real d = step.spacing, dt = step.dt;
    const Real of_tension = Real(0.01) * static_cast<Real>(s.options.tension) / (step.rest_density * d);
    const Real slowest = s.options.free_surface ? Real(0.25) * std::sqrt(step.gravity.norm() * d + of_tension) : 0;
    std::vector<Vec3> change(n, Vec3::Zero());
    s.shift.assign(n, Vec3::Zero());
    const Real speed = std::max(slowest, max_speed_of(u.values));
    parallel_for(n, [&](Index i) {
        if (role[i] != 0 || context.pairs.count(i) == 0) return;
        bool near = s.surface[i];
        if (s.options.free_surface)
            context.pairs.of(i, [&](Index j, const Vec3&, Real r) { near = near || (s.surface[j] && r < Real(1.5) * d); });
        Vec3 move = -s.options.shift_rate * speed * step.support / 2 * dt * s.spread[i];
        if (near) {
            const Vec3 out = s.inward[i].normalized();
            move -= move.dot(out) * out;
        }
        const Real length = move.norm(), most = std::min(speed * dt / 2, d / 10);
        if (length > most) move *= most / length;
        // PushOutOfSolids would revert a shift into a wall, but not the change of velocity that belongs to the shift.
        s.walls_of(i, [&](const WallTouch& touch) {
            const Vec3& normal = context.boundary.normal[touch.s];
            move += std::max(Real(0), -move.dot(normal) - std::max(Real(0), touch.height)) * normal;
        });
        s.shift[i] = move;
    });
    if (s.options.tension > 0) level_surface(context, role);
    lift_nothing(step.gravity, s.shift);
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(n, [&](Index i) {
            if (s.shift[i] == Vec3::Zero()) return;
            change[i] = carried(W, s.whole, context.pairs, i, step.volume, u.data(), s.shift[i]);
            if (!s.options.free_surface && s.any_walls && context.solid_pairs.count(i) > 0)
                limit_outlier(W, context.pairs, i, u.values, change[i]);
        });
    });
    parallel_for(n, [&](Index i) { x[i] += s.shift[i], u[i] += change[i], s.start_velocity[i] += change[i]; });
}

}  // namespace whorl

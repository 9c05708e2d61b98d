#include "engine/models/pressure/poisson.h"

#include <limits>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/boundary/wall.h"

namespace whorl {
namespace {

/// A region is singular if its pins are less than this fraction of its diagonals. The pins of a closed region consist of alpha alone
/// (pressure_matrix.h). In a full box alpha differs from 0 only because neighbours are uneven; after particles have left a lattice, alpha
/// is a hundredth of the diagonal. For a few particles on a floor alpha is as large as the diagonal.
constexpr double weakly_tied = 0.05;
/// The same fraction for the printed form. There the pressure level is undetermined only in a drop that has no surface particles and
/// touches no solid.
constexpr double untied = 1e-6;

/// Threshold of (divergence of the position)/(number of dimensions). Smaller values mark a free surface.
constexpr Real full_enough = Real(0.85);

}  // namespace

/// A particle is on the free surface if the divergence of the position is small. In 3D it is 3 inside the fluid (3.06 on a lattice with R =
/// 2 d) and 2.24 in the outermost layer of a flat lattice. Solids count like fluid. A compressed particle is never on the surface, even if
/// it has few neighbours, because it needs a pressure.
template <class Kernel>
void PoissonPressure::classify(const Kernel& kernel, const InteractionContext& context, Read<field::role> role, Read<field::density> rho) {
    const auto D = static_cast<Real>(context.step.dimensions());
    parallel_for(rho.size(), [&](Index i) {
        PressureClass& mine = class_[i];
        spread_[i] = 1;
        if (role[i] != 0) {
            mine = PressureClass::prescribed;
            return;
        }
        const Index fluid_neighbours = context.pairs.count(i),
                    solid_neighbours = context.boundary.size() > 0 ? context.solid_pairs.count(i) : 0;
        if (fluid_neighbours == 0) {
            mine = solid_neighbours == 0 ? PressureClass::isolated : PressureClass::separated;
            return;
        }
        Real divergence = 0;
        context.pairs.of(i, [&](Index, const Vec3&, Real r) { divergence -= context.step.volume * kernel.derivative(r) * r; });
        if (solid_neighbours > 0)
            context.solid_pairs.of(i, [&](Index s, const Vec3&, Real r) {
                divergence -= gate_[i] * options_.solid_factor * context.boundary.volume[s] * kernel.derivative(r) * r;
            });
        mine = divergence < full_enough * D && rho[i] < context.step.rest_density ? PressureClass::surface : PressureClass::poisson;
        if (mine == PressureClass::poisson && !options_.printed) spread_[i] = std::max(full_enough, divergence / D);
    });
}

template <class Kernel>
void PoissonPressure::weigh(const Kernel& kernel, const InteractionContext& context, Read<field::density> rho) {
    constexpr Real least = Real(0.25);  // lower bound for the space that solids leave, for particles between two walls
    const bool walls = context.boundary.size() > 0;
    const Real lacking =
        walls && !options_.printed ? lacking_along_wall(context.step.kernel, context.step.support, context.step.spacing) : 0;
    parallel_for(rho.size(), [&](Index i) {
        gate_[i] = walls ? options_.gate.weight(kernel, i, context.solid_pairs, context.boundary.volume, options_.solid_factor) : Real(1);
        Real behind = 0;
        if (walls) context.solid_pairs.of(i, [&](Index s, const Vec3&, Real r) { behind += context.boundary.volume[s] * kernel.value(r); });
        const Real ratio = context.step.rest_density / rho[i];
        weight_[i] = ratio * ratio;
        fill_[i] = 1 / std::max(least, 1 - lacking * gate_[i] * options_.solid_factor * behind);
    });
}

template <class Kernel>
Real PoissonPressure::solid_slope(const Kernel& kernel, const InteractionContext& context, Index i, Index s, Real distance) const {
    return gate_[i] * options_.solid_factor * context.boundary.volume[s] / spread_[i] * kernel.slope(distance);
}

/// Contribution of boundary particle s to D_i, without the weight of i.
template <class Kernel>
Vec3 PoissonPressure::of_solid(const Kernel& kernel, const InteractionContext& context, Index i, Index s, const Vec3& r,
                               Real distance) const {
    const Vec3& normal = context.boundary.normal[s];
    if (options_.printed) return solid_slope(kernel, context, i, s, distance) * r;
    const Real stretch = WallShear{context.step.spacing / 2}.stretch(r, normal);
    return solid_slope(kernel, context, i, s, distance) * (r + (stretch - 1) * r.dot(normal) * normal);
}

/// The pressure of boundary particle s is p_i plus the weight of the fluid between i and s, rho_0 g.(x_s - x_i) along the normal. The
/// weight is known before the solve. Without the weight the pressure of the lowest layer is too high by the pressure of its own weight, and
/// the topmost layer of a full box falls.
template <class Kernel>
void PoissonPressure::carry(const Kernel& kernel, const InteractionContext& context, Read<field::role> role,
                            Update<field::velocity> u) const {
    if (context.boundary.size() == 0 || options_.printed) return;
    const StepContext& step = context.step;
    const auto carried = [&](Index i, Index s, const Vec3& r, Real distance) {
        const Vec3& normal = context.boundary.normal[s];
        return Vec3(solid_slope(kernel, context, i, s, distance) * step.gravity.dot(normal) * std::max(Real(0), r.dot(normal)) * r);
    };
    parallel_for(matrix_.size(), [&](Index i) {
        if (class_[i] != PressureClass::poisson) return;
        Vec3 sum = Vec3::Zero();
        context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) { sum += carried(i, s, r, distance); });
        u[i] += step.dt * weight_[i] * sum;
    });
    react(context, Push::pressure, role, step.mass * step.dt, [&](Index i) {
        const Real weight = class_[i] == PressureClass::poisson ? weight_[i] : 0;
        return [&, i, weight](Index s, const Vec3& r, Real distance) { return Vec3(weight * carried(i, s, r, distance)); };
    });
}

/// Right-hand side of a row. @param factor of the row @param error relative density error @param rate of the relative density [1/s]
Real PoissonPressure::source(const StepContext& step, Real factor, Real error, Real rate) const {
    const Real share = static_cast<Real>(options_.correction.value_or(0.1));
    return step.rest_density * step.volume * factor * (share * error + step.dt * rate) / (step.dt * step.dt);
}

/// Row i is multiplied by w_i V, in the printed form by V_i = V sqrt(w_i), which makes the matrix symmetric.
template <bool printed, class Kernel>
void PoissonPressure::set_rows(const Kernel& kernel, const InteractionContext& context, Read<field::density> rho, Update<field::velocity> u,
                               Update<field::pressure> p) {
    const StepContext& step = context.step;
    const Real V = step.volume;
    const Real enough = V * Real(1e-6) / (step.spacing * step.spacing);
    const Real alone = V * kernel.value(0) + touching_wall_sum(step.kernel, step.support, step.spacing);  // a separated particle at a wall
    parallel_for(rho.size(), [&](Index i) {
        const PressureClass mine = class_[i];
        const bool unknown = mine == PressureClass::poisson;
        b_[i] = 0;
        touches_surface_[i] = 0;
        if (!unknown && mine != PressureClass::separated) return;

        const Real own = weight_[i], factor = printed ? std::sqrt(own) : own;
        std::size_t k = context.pairs.first[i];
        Real row = 0, pin = 0, rate = 0;
        Vec3 uniform = Vec3::Zero();
        bool surface = false;
        context.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
            const Real filled = between(i, j), slope = kernel.slope(distance);
            Real& coefficient = matrix_.c[k++];
            coefficient = 0;
            const Vec3 gradient = filled * V * slope * r;
            rate += (u[i] - u[j]).dot(gradient);
            if (class_[j] == PressureClass::prescribed) {
                uniform += 2 * own * gradient;
                return;
            }
            if (!printed) uniform += (own + weight_[j]) * gradient;
            const Real c = filled * filled * V * V * factor * (printed ? std::sqrt(weight_[j]) : weight_[j]) * -2 * slope;
            if (class_[j] == PressureClass::poisson) {
                if (unknown) coefficient = c;
                row += c;
            } else {
                pin += c, surface = true;
            }
        });
        if (context.boundary.size() > 0)
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                const Vec3 gradient = of_solid(kernel, context, i, s, r, distance);
                rate += (u[i] - context.boundary.velocity[s]).dot(gradient);
                uniform += own * gradient;
            });
        if (printed) uniform *= std::sqrt(factor / own);
        const Real alpha = V * uniform.squaredNorm();
        pin += alpha;
        b_[i] = source(step, factor, rho[i] / step.rest_density - (unknown || printed ? 1 : alone), rate);
        if (unknown) {
            matrix_.pin[i] = pin;
            matrix_.diagonal[i] = std::max(row + pin, min_positive);
            touches_surface_[i] = surface;
        } else {
            // Between two facing walls the gradients cancel, so a pressure would accelerate no particle.
            p[i] = alpha > enough ? b_[i] / alpha : 0;
            if (options_.clamp) p[i] = std::max(Real(0), p[i]);
            b_[i] = 0;
        }
    });
}

/// The tolerance is a relative density error: |r| is compared with the norm of a residual of rho_0/dt^2 at every particle. In small time
/// steps this norm alone would leave the pressure unsolved (in 40 layers, a residual of 1e-4 with the longest wavelength changes the
/// pressure by several times the layers' weight). So the reference is at most ten times the norm of the right-hand side.
SolveReport PoissonPressure::solve_rows(const StepContext& step, double unknowns, Span<Real> x) {
    SolveReport solved;
    solved.converged = true;
    if (!(unknowns > 0)) return solved;
    const double start = wall_seconds();
    const PressurePreconditioner M = preconditioner_(matrix_);
    const double set_up = wall_seconds() - start;
    const auto A = [&](Span<const Real> in, Span<Real> out) { matrix_.multiply(in, out); };
    const double density =
        std::sqrt(unknowns) * static_cast<double>(step.volume) * step.rest_density / (static_cast<double>(step.dt) * step.dt);
    const double source = 10 * std::sqrt(dot<Real>(b_, b_));
    const double reference = source > 0 ? std::min(density, source) : density;
    solved = conjugate_gradients<Real>(A, M, Span<const Real>(b_), x, options_.limits, ResidualNorm::euclidean, reference);
    solved.levels = M.levels;
    solved.set_up_seconds = set_up;
    solved.solve_seconds = wall_seconds() - start - set_up;
    return solved;
}

/// Removes the mean density error of a full box from the right-hand side, because no flow can correct it.
void PoissonPressure::take_mean_errors_away(const StepContext& step, Read<field::density> rho) {
    for (const ClosedRegion& region : closed_.all) {
        if (!region.singular) continue;
        double mean = 0;
        for (Index i : region.members) mean += rho[i];
        mean /= static_cast<double>(region.members.size());
        for (Index i : region.members) b_[i] -= source(step, weight_[i], static_cast<Real>(mean) / step.rest_density - 1, 0);
    }
}

/// Without a surface the zero of the pressure is arbitrary. The lowest pressure is set to the weight of a layer, so that the clamp changes
/// no pressure.
void PoissonPressure::choose_zero(const StepContext& step, Span<Real> x) const {
    const Real layer = step.rest_density * step.gravity.norm() * step.spacing;
    for (const ClosedRegion& region : closed_.all) {
        if (!region.singular) continue;
        Real lowest = std::numeric_limits<Real>::max();
        for (Index i : region.members) lowest = std::min(lowest, x[i]);
        for (Index i : region.members) x[i] += layer - lowest;
    }
}

void PoissonPressure::solve(const StepContext& step, StepReport& report, Update<field::pressure> p) {
    const Index n = matrix_.size();
    Column<Real> x(n);
    const double unknowns = parallel_sum(n, [&](Index i) {
        const bool unknown = matrix_.unknown[i];
        x[i] = unknown ? p[i] : 0;
        return static_cast<double>(unknown);
    });
    report.solves.push_back({SolveKind::pressure, solve_rows(step, unknowns, x)});
    if (options_.clamp) choose_zero(step, x);
    parallel_for(n, [&](Index i) {
        if (class_[i] != PressureClass::separated) p[i] = options_.clamp ? std::max(Real(0), x[i]) : x[i];
    });
}

/// u_i -= dt/rho_0 (D^T p)_i / V
template <class Kernel>
void PoissonPressure::push(const Kernel& kernel, const InteractionContext& context, Read<field::role> role, Update<field::velocity> u,
                           Update<field::pressure> p) const {
    const StepContext& step = context.step;
    parallel_for(matrix_.size(), [&](Index i) {
        if (class_[i] == PressureClass::prescribed) return;
        const Real own = weight_[i] * p[i];
        Vec3 sum = Vec3::Zero();
        context.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
            const Real other = class_[j] == PressureClass::prescribed ? own : weight_[j] * p[j];
            sum += between(i, j) * step.volume * (own + other) * kernel.slope(distance) * r;
        });
        if (own != 0 && context.boundary.size() > 0)
            context.solid_pairs.of(
                i, [&](Index s, const Vec3& r, Real distance) { sum += own * of_solid(kernel, context, i, s, r, distance); });
        u[i] -= step.dt / step.rest_density * sum;
    });
    react(context, Push::pressure, role, -step.dt * step.mass / step.rest_density, [&](Index i) {
        const Real own = weight_[i] * p[i];
        return [&, i, own](Index s, const Vec3& r, Real distance) { return Vec3(own * of_solid(kernel, context, i, s, r, distance)); };
    });
}

void PoissonPressure::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::density> rho,
                                 Update<field::velocity> u, Update<field::pressure> p) {
    const Index n = context.pairs.size();
    class_.resize(n), touches_surface_.resize(n), gate_.resize(n), b_.resize(n), weight_.resize(n), fill_.resize(n), spread_.resize(n);
    matrix_.unknown.resize(n);
    with_kernel(context.step.kernel, context.step.support, [&](const auto& kernel) {
        weigh(kernel, context, rho);
        classify(kernel, context, role, rho);
        parallel_for(n, [&](Index i) { matrix_.unknown[i] = class_[i] == PressureClass::poisson; });
        matrix_.lay_out(context.pairs, context.step.spacing);
        carry(kernel, context, role, u);
        if (options_.printed) set_rows<true>(kernel, context, rho, u, p);
        else set_rows<false>(kernel, context, rho, u, p);
        closed_.find(matrix_, touches_surface_, options_.printed ? untied : weakly_tied);
        if (options_.printed) closed_.subtract_means(b_);
        else take_mean_errors_away(context.step, rho);
        solve(context.step, report, p);
        push(kernel, context, role, u, p);
    });
}

}  // namespace whorl

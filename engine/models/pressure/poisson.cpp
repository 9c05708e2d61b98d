#include "engine/models/pressure/poisson.h"

#include <limits>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/pressure/wall_pressure.h"

namespace whorl {
namespace {

/// The share of alpha that counts. alpha is what the wall's push does to the density of i by moving i; but as p_i rises, so does the push
/// of the fluid on the other side, and next to a wall with fluid against it the two cancel: a uniform pressure moves nothing. The whole
/// alpha, as in the notes, is right for a particle without fluid neighbours; elsewhere the lowest layer settles too dense (by 2 % under 40
/// layers at d = 1 cm and dt = 1 ms). 0 up to an imbalance of 0.3, so that uneven neighbours do not count as a gap.
Real unbalanced(const Vec3& fluid, const Vec3& solid) {
    const Real size = solid.squaredNorm();
    if (!(size > 0)) return 0;
    const Real share = std::max(Real(0), (1 + fluid.dot(solid) / size - Real(0.3)) / Real(0.7));
    return std::min(Real(1), share * share);
}

}  // namespace

/// Free surface: the divergence of the position, 3 inside the fluid (3.06 on a lattice with R = 2 d), 2.24 in the outermost layer of a flat
/// lattice; solids count as fluid does. A particle that is compressed is no surface, however few its neighbours: it needs a pressure.
template <class Kernel>
void PoissonPressure::classify(const Kernel& kernel, const Surroundings& around, Read<field::role> role, Read<field::density> rho) {
    constexpr Real surface_divergence = Real(2.55);
    parallel_for(rho.size(), [&](Index i) {
        PressureClass& mine = class_[i];
        if (role[i] != 0) {
            mine = PressureClass::prescribed;
            return;
        }
        const Index fluid_neighbours = around.pairs.count(i), solid_neighbours = around.layer.size() > 0 ? around.solid_pairs.count(i) : 0;
        if (fluid_neighbours == 0) {
            mine = solid_neighbours == 0 ? PressureClass::isolated : PressureClass::separated;
            return;
        }
        Real divergence = 0;
        around.pairs.of(i, [&](Index, const Vec3&, Real r) { divergence -= around.step.volume * kernel.derivative(r) * r; });
        if (solid_neighbours > 0)
            around.solid_pairs.of(i, [&](Index s, const Vec3&, Real r) {
                divergence -= gate_[i] * options_.solid_factor * around.layer.volume[s] * kernel.derivative(r) * r;
            });
        mine = divergence < surface_divergence && rho[i] < around.step.rest_density ? PressureClass::surface : PressureClass::poisson;
    });
}

template <class Kernel>
void PoissonPressure::build(const Kernel& kernel, const Surroundings& around, Read<field::density> rho, Update<field::velocity> u,
                            Update<field::pressure> p) {
    parallel_for(rho.size(), [&](Index i) {
        wall_[i] = around.layer.size() > 0 ? Vec3(gate_[i] * wall_gradient(kernel, i, around, options_.solid_factor)) : Vec3(Vec3::Zero());
    });
    lay_out_rows(around.pairs);
    set_rows(kernel, around, rho, u, p);
}

/// Room for the unknown neighbours of each unknown.
void PoissonPressure::lay_out_rows(const FluidPairs& pairs) {
    const Index n = pairs.size();
    for (Index i = 0; i < n; ++i) {
        Index unknowns = 0;
        if (class_[i] == PressureClass::poisson)
            for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k) unknowns += class_[pairs.other[k]] == PressureClass::poisson;
        matrix_.first[i + 1] = matrix_.first[i] + static_cast<std::size_t>(unknowns);
    }
    matrix_.other.resize(matrix_.first[n]);
    matrix_.c.resize(matrix_.first[n]);
}

template <class Kernel>
void PoissonPressure::set_rows(const Kernel& kernel, const Surroundings& around, Read<field::density> rho, Update<field::velocity> u,
                               Update<field::pressure> p) {
    const SolidParticles& layer = around.layer;
    const StepContext& step = around.step;
    const Index n = rho.size();
    const Real rho_0 = step.rest_density, over_dt2 = 1 / (step.dt * step.dt);
    const auto slope_at = [&](Real r) { return kernel.derivative(r) / std::max(r, smallest); };
    const WallShear wall{step.spacing / 2};
    parallel_for(n, [&](Index i) {
        const PressureClass mine = class_[i];
        const bool unknown = mine == PressureClass::poisson;
        matrix_.unknown[i] = unknown;
        matrix_.diagonal[i] = 1;
        matrix_.pin[i] = b_[i] = 0;
        touches_surface_[i] = 0;
        Vec3 boundary = wall_[i], prescribed = Vec3::Zero(), fluid = Vec3::Zero();
        wall_[i].setZero();
        if (!unknown && mine != PressureClass::separated) return;

        const Real V = step.mass / rho[i];
        std::size_t k = matrix_.first[i];
        Real row = 0, pin = 0, rate = 0;
        bool surface = false;
        around.pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
            const Vec3 gradW = slope_at(distance) * r;
            rate += step.mass * (u[i] - u[j]).dot(gradW);
            const Real Vj = step.mass / rho[j];
            const Real c = V * Vj * -2 * slope_at(distance);
            fluid += Vj * gradW;
            switch (class_[j]) {
                case PressureClass::poisson:
                    matrix_.other[k] = j;
                    matrix_.c[k++] = c;
                    row += c;
                    break;
                case PressureClass::prescribed: prescribed += step.volume * gradW; break;
                default: pin += c, surface = true;
            }
        });
        if (layer.size() > 0)
            around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                // The flow turns at the surface, not at the solid particle behind it: the normal part is continued like shear.
                const Vec3 n_s = layer.normal[s], u_is = u[i] - layer.velocity[s];
                const Vec3 turned = u_is + (wall.stretch(r, n_s) - 1) * u_is.dot(n_s) * n_s;
                rate += gate_[i] * rho_0 * options_.solid_factor * layer.volume[s] * slope_at(distance) * turned.dot(r);
            });
        boundary += prescribed;
        wall_[i] = rho_0 / (rho[i] * rho[i]) * prescribed;  // the other half comes from the sum over the pairs
        const Real alpha = 2 * (rho_0 / rho[i]) * (rho_0 / rho[i]) * boundary.squaredNorm() * unbalanced(fluid, boundary);
        pin += V * alpha;
        b_[i] = V * (static_cast<Real>(options_.density_correction) * (rho[i] - rho_0) + step.dt * rate) * over_dt2;
        if (unknown) {
            matrix_.pin[i] = pin;
            matrix_.diagonal[i] = std::max(row + pin, smallest);
            touches_surface_[i] = surface;
        } else {
            // Between two facing walls the gradients cancel: no pressure pushes anywhere.
            const Real enough = Real(1e-6) / (step.spacing * step.spacing);
            p[i] = alpha > enough ? std::max(Real(0), b_[i] / (V * alpha)) : 0;
            b_[i] = 0;
        }
    });
}

/// |r| is held against that of a residual of rho_0/dt^2 everywhere: the tolerance is a relative density error. At small time steps that
/// alone would leave the pressure unsolved (a density error of 1e-4 in the longest wave of 40 layers is several times their weight), so it
/// is also a share of the source.
SolveReport PoissonPressure::solve_rows(const StepContext& step, double unknowns, Span<Real> x) {
    SolveReport solved;
    solved.converged = true;
    if (!(unknowns > 0)) return solved;
    const double start = wall_seconds();
    const PressurePreconditioner M = options_.preconditioner(matrix_);
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

/// Without a surface the pressure has no natural zero. Its lowest value is made the weight of a layer, so that neither the clamp of solve()
/// nor that of a ceiling (wall_push) takes anything away.
void PoissonPressure::choose_zero(const StepContext& step, Span<Real> x) const {
    const Real layer = step.rest_density * step.gravity.norm() * step.spacing;
    for (const ClosedRegion& component : closed_.all) {
        Real lowest = component.singular ? std::numeric_limits<Real>::max() : 0;
        for (Index i : component.members) lowest = std::min(lowest, x[i]);
        const Real shift = component.singular ? layer - lowest : -lowest;
        for (Index i : component.members) x[i] += shift;
    }
}

void PoissonPressure::solve(const StepContext& step, StepReport& report, Update<field::pressure> p) {
    const Index n = matrix_.size();
    closed_.take_means_away(b_);
    Column<Real> x(n);
    const double unknowns = parallel_sum(n, [&](Index i) {
        const bool unknown = matrix_.unknown[i];
        x[i] = unknown ? p[i] : 0;
        return static_cast<double>(unknown);
    });
    report.solves.push_back({"pressure", solve_rows(step, unknowns, x)});
    choose_zero(step, x);
    parallel_for(n, [&](Index i) {
        if (class_[i] != PressureClass::separated) p[i] = std::max(Real(0), x[i]);
    });
}

/// u_i -= dt sum_j m (p_i/rho_i^2 + p_j/rho_j^2) grad W_ij + dt (push of prescribed neighbours and solids)
template <class Kernel>
void PoissonPressure::push(const Kernel& kernel, const Surroundings& around, Read<field::density> rho, Update<field::velocity> u,
                           Update<field::pressure> p) const {
    const StepContext& step = around.step;
    parallel_for(rho.size(), [&](Index i) {
        if (class_[i] == PressureClass::prescribed) return;
        const Real own = p[i] / (rho[i] * rho[i]);
        Vec3 sum = Vec3::Zero();
        around.pairs.of(
            i, [&](Index j, const Vec3& r, Real distance) { sum += (own + p[j] / (rho[j] * rho[j])) * kernel.slope(distance) * r; });
        u[i] -= step.dt * (step.mass * sum + p[i] * wall_[i]);
        if (p[i] > 0 && around.layer.size() > 0)
            u[i] -= step.dt * gate_[i] * step.rest_density / (rho[i] * rho[i]) * wall_push(kernel, i, around, options_.solid_factor, p[i]);
    });
}

void PoissonPressure::resize(const Surroundings& around) {
    const Index n = around.pairs.size();
    class_.resize(n), touches_surface_.resize(n), gate_.resize(n), b_.resize(n), wall_.resize(n);
    matrix_.first.assign(static_cast<std::size_t>(n) + 1, 0);
    matrix_.diagonal.resize(n), matrix_.pin.resize(n), matrix_.unknown.resize(n);
    matrix_.x = around.pairs.x_own;
    matrix_.spacing = around.step.spacing;
}

void PoissonPressure::operator()(const Surroundings& around, StepReport& report, Read<field::role> role, Read<field::density> rho,
                                 Update<field::velocity> u, Update<field::pressure> p) {
    resize(around);
    with_kernel(around.step.kernel, around.step.support, [&](const auto& kernel) {
        parallel_for(rho.size(), [&](Index i) {
            gate_[i] = around.layer.size() > 0
                           ? options_.gate.weight(kernel, i, around.solid_pairs, around.layer.volume, options_.solid_factor)
                           : Real(1);
        });
        classify(kernel, around, role, rho);
        build(kernel, around, rho, u, p);
        closed_.find(matrix_, touches_surface_);
        solve(around.step, report, p);
        push(kernel, around, rho, u, p);
    });
}

}  // namespace whorl

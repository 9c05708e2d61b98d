#pragma once
/// Data that the stages of the divergence-free projection share within a step (docs/physics.md). Symbols in this folder: V volume of a
/// particle, W kernel, R its support, d spacing, D dimensions, r = x_i - x_j.
///
/// Order of a step; the neighbours are found at the positions to which the flow takes the particles:
///   ProjectionDrift, neighbours, ProjectionGeometry, Gravity, CorrectedViscosity, Kick, Projection, ProjectionMove, PushOutOfSolids.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "engine/core/parallel.h"
#include "engine/math/inverse_in.h"
#include "engine/math/kernel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/boundary/near_walls.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/pressure/expected_force.h"
#include "engine/models/pressure/mirrors.h"
#include "engine/models/pressure/pressure_matrix.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/sph/gate.h"

namespace whorl {

namespace field {
struct pressure_acceleration {
    using type = Vec3;
    static constexpr std::string_view name = "pressure_acceleration", unit = "m/s^2", meaning = "grad p / rho of the last step";
};
struct solved_pressure {
    using type = Real;
    static constexpr std::string_view name = "solved_pressure", unit = "Pa",
                                      meaning = "pressure at the end of the last step, may alternate from step to step";
};
}  // namespace field

struct ProjectionOptions {
    /// tolerance: residual of the first solve, divided by the norm of its right-hand side
    SolveLimits limits{1e-3, 200};
    double later_tolerance = 0.1;  ///< tolerance of the later solves, which correct the remainder of the first
    int solves = 2;                ///< the plan sets 3 near walls and free surfaces, because with 2 a column in a slot creeps down
    /// Weight of the new pressure in a step; the old pressure has the weight 1 - theta. With 1/2 the step is of second order, and pressures
    /// oscillate near walls.
    double theta = 0.5;
    bool free_surface = false;
    /// true: for a free surface without gravity and surface tension, which would smooth it. Near the surface the force of a pair then
    /// contains the pressures of both particles.
    bool bare_surface = false;
    double tension = 0;      ///< surface tension of a free surface [N/m]
    bool sharp = true;       ///< use the SharpKernel inside the fluid; false for fluid with spin, because this kernel makes spins noisy
    Real shift_rate = 1.25;  ///< a larger rate adds energy; with a smaller one a lattice breaks up into clumps
    SolidGate gate;
    PressurePreconditionerSetup preconditioner;
};

/// A boundary particle near fluid particle i, with the column of lattice layers behind it.
struct WallTouch {
    Index s;
    Real flux;    ///< weight of the normal velocity at the wall in the divergence: sum_l 2 V W'(r_l)/r_l (r_l.n), <= 0 [1/m]
    Real height;  ///< height of i above the wall [m]
};

/// Sums of a kernel over the fluid neighbours. With these sums gradients and Laplacians are exact for linear fields.
struct LinearSums {
    Column<Mat3> correction;  ///< (-sum_j V W'/r r r^T)^-1
    Column<Real> trace;       ///< trace of the inverse of `correction`
    Column<Vec3> imbalance;   ///< sum_j V W'/r r [1/m]
    void resize(Index n) { correction.resize(n), trace.resize(n), imbalance.resize(n); }
};

/// Kernel with the slope norm W'/r (1 - b r^2), whose fourth moment on a lattice is 0. So Laplacians and gradients are of fourth order on a
/// lattice. With W itself, R = 3 d and 32 particles per wave, Laplacians and gradients of crossing waves are 1.2 and 2.4 % too small. The
/// largest eigenvalue of the Laplacian is 6.5/d^2 in 2D and 6.9/d^2 in 3D, so two stages are stable with viscous_step()
/// (models/viscosity/explicit_viscosity.h). For narrower kernels b is limited such that two stages stay stable.
template <class Kernel>
struct SharpKernel {
    Kernel W;
    Real b = 0, norm = 1;  ///< norm keeps the second moment
    SharpKernel(const Kernel& kernel, Real d) : W(kernel) {
        double second = 0, fourth = 0, sixth = 0;
        each_lattice_point(W.dimensions, static_cast<int>(std::ceil(W.R / d)), [&](int x, int y, int z) {
            const auto square = static_cast<Real>(x * x + y * y + z * z) * d * d;
            const auto q = static_cast<double>(square), F = static_cast<double>(W.slope(std::sqrt(square)));
            second += F * q, fourth += F * q * q, sixth += F * q * q * q;
        });
        constexpr double most = 4.5;
        const double share = std::min(fourth / sixth, (1 - 1 / most) * second / fourth);
        b = static_cast<Real>(share);
        norm = static_cast<Real>(second / (second - share * fourth));
    }
    Real value(Real r) const { return W.value(r); }
    Real slope(Real r) const { return norm * (1 - b * r * r) * W.slope(r); }
};

/// Support, as a fraction of the usual one, of the kernel that viscosity, spin and curls use near walls and free surfaces.
inline constexpr Real one_sided_support = Real(0.8);

/// Calls f(sharp, narrow) with the two kernels of viscosity, spin and curls. `sharp` is for particles inside the fluid, `narrow` for the
/// others.
template <class F>
void with_viscous_kernels(const StepContext& step, F&& f) {
    with_kernel(step.kernel, step.support, [&]<class Kernel>(const Kernel& W) {
        f(SharpKernel(W, step.spacing), Kernel(one_sided_support * step.support, step.dimensions()));
    });
}

struct ProjectionSystem {
    explicit ProjectionSystem(ProjectionOptions o) : options(std::move(o)) {}
    ProjectionOptions options;

    Remainder remainder;              ///< of the momentum, constructed before the pressure, shared in the move
    std::vector<std::size_t> closed;  ///< solids with an exact pressure (PressureOnBodies::write_closed())
    Column<Vec3> before;              ///< velocities before the pressure of the step; empty: no probe reads a ledger
    bool expected = false;            ///< ExpectPressure applied the whole of the last step's pressure
    Column<Vec3> start_velocity;      ///< at the start of the step
    struct BodyVelocity {
        Vec3d velocity, turning;
    };
    std::vector<BodyVelocity> body_start;  ///< velocities of the free bodies at the start of the step

    LinearSums whole;               ///< sums of the kernel itself
    LinearSums viscous;             ///< sums of the SharpKernel for particles `inside`, of the kernel with one_sided_support for others
    std::vector<char> inside;       ///< 1: not near a wall or a free surface, where the SharpKernel would be less accurate
    Column<Vec3> spread;            ///< sum V [1 + 0.2 (W/W(d))^4] W'/r r over fluid and solids [1/m]
    Column<Vec3> inward;            ///< sum V W'/r r over fluid and solids [1/m]: points into the fluid at a free surface
    Column<Real> gate;              ///< weight of the solids
    Column<Vec3> shift;             ///< displacement by ProjectionShift [m]
    Column<Real> surface_pressure;  ///< pressure of the free surface, for particles near it [Pa]; empty: 0
    Column<Vec3> surface_normal;    ///< outward normal of particles with a surface_pressure
    Column<Real> air;               ///< missing part of a full neighbourhood's sum of -2 V W'/r near a free surface [1/m^2]
    std::vector<char> surface, near_surface;
    std::vector<char> near_edge;           ///< 1: in a full room, within 1.5 d of two walls that meet
    bool narrow = false;                   ///< full room in 3D with fluid in a gap of less than 5.5 d between walls
    Column<Mat3> of_gradient;              ///< if narrow: weights of the velocity gradient in the divergence; otherwise empty
    Mirrors mirrors;                       ///< images of the fluid behind flat walls
    std::vector<char> slides;              ///< 1: the fluid slips freely along all walls that make the image
    std::vector<std::size_t> first_touch;  ///< n + 1, into touches
    std::vector<WallTouch> touches;
    bool any_walls = false;

    Index size() const { return static_cast<Index>(inside.size()); }
    Real pressure_outside(Index i) const { return surface_pressure.empty() ? Real(0) : surface_pressure[i]; }
    /// Largest grad p/rho that the next step reuses [m/s^2]. A larger value comes from an impact, which must not act twice.
    Real most_carried(const StepContext& step) const {
        return options.free_surface ? Real(0.04) * step.spacing / (step.dt * step.dt) : std::numeric_limits<Real>::infinity();
    }
    /// Frequency of the shortest waves of a free surface, from gravity and surface tension [1/s].
    Real shortest_waves(const StepContext& step) const {
        const Real d = step.spacing;
        return std::sqrt(step.gravity.norm() / d + static_cast<Real>(options.tension) / (step.rest_density * d * d * d));
    }
    /// Factor on the sums over neighbours that gives a Laplacian. @param trace of -sum F r r^T @param over_lattice 1/lattice_gradient()
    Real laplacian_scale(const StepContext& step, Index i, Real trace, Real over_lattice) const {
        return near_surface[i] ? 2 * over_lattice : 2 * static_cast<Real>(step.dimensions()) / std::max(trace, Real(0.1));
    }
    /// Calls f(touch) for the boundary particles around i.
    template <class F>
    void walls_of(Index i, F&& f) const {
        if (!any_walls) return;
        for (std::size_t k = first_touch[i]; k < first_touch[i + 1]; ++k) f(touches[k]);
    }
};

/// u -= dt g, with g = grad p/rho of the last step. Runs before an implicit viscosity, so that the viscosity resists only strain. Otherwise
/// the viscosity would first damp motion that the pressure removes anyway, as in a rotating body. Projection later undoes the part of this
/// change that exceeds the share of the old pressure.
struct ExpectPressure {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context, Read<field::role> role, Read<field::pressure_acceleration> a,
                    Update<field::velocity> u) const {
        const StepContext& step = context.step;
        const Real most = system->most_carried(step);
        system->expected = true;
        parallel_for(u.size(), [&](Index i) {
            if (role[i] == 0 && a[i].norm() < most) u[i] -= step.dt * a[i];
        });
        ExpectedOnBodies::expect(context, most);
    }
};

/// x* = x + dt u, so that the forces of the step act at the new positions.
struct ProjectionDrift {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const StepContext& step, Read<field::velocity> u, Update<field::position> x) const {
        system->start_velocity.assign(u.values.begin(), u.values.end());
        parallel_for(x.size(), [&](Index i) { x[i] = step.domain.wrapped(x[i] + step.dt * u[i]); });
    }
};

/// Finds the moments of the neighbourhoods, the walls and the free surface. The density is the kernel sum, a measure of how evenly the
/// particles are distributed.
struct ProjectionGeometry {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const InteractionContext& context, Read<field::role> role, Write<field::density> rho) const;
};

}  // namespace whorl

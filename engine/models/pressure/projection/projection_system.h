#pragma once
/// Data that the stages of the divergence-free projection share within a step (docs/physics.md). Symbols in this folder: V volume of a
/// particle, W kernel, R its support, d spacing, D dimensions, r = x_i - x_j.
///
/// Order of a step; the neighbours are found at the positions to which the flow takes the particles:
///   ProjectionDrift, neighbours, ProjectionGeometry, Gravity, CorrectedViscosity, Kick, Projection, ProjectionMove, PushOutOfSolids.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <type_traits>

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

/// Velocity of the wall's surface in front of boundary particle q.
inline Vec3 surface_velocity(const InteractionContext& context, Index q) {
    const BoundaryParticles& boundary = context.boundary;
    return boundary.velocity[q] +
           context.step.spacing / 2 * context.solids.all[boundary.solid[q]].pose.angular_velocity.cross(boundary.normal[q]);
}

/// Calls f(q, F, continued, to, distance) for each lattice layer behind boundary particle q near i. F = V W'/r [1/m^2]. `continued`, at
/// most 12, is the factor on u_i - u_wall that continues the shear into the layer. `to` points from the layer to i, `distance` is its
/// length. @param of_layer layer_factor() @param r from q to i
template <class Kernel, class Visit>
void each_layer_of(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Real of_layer, Index q,
                   const Vec3& r, Visit&& f) {
    const Vec3& normal = context.boundary.normal[q];
    const Real d = context.step.spacing, above = r.dot(normal), volume = s.gate[i] * of_layer * context.boundary.volume[q],
               height = std::max(above - d / 2, d / 4);
    each_layer(r, normal, d, context.step.support, [&](const Vec3& to, Real distance, Real below) {
        f(q, volume * W.slope(distance), above > 0 ? std::min(Real(12), 1 + below / height) : Real(1), to, distance);
    });
}
/// Calls each_layer_of() for the boundary particles near i of solids to which the fluid sticks. @param slip slips() of the solids
template <class Kernel, class Visit>
void each_sticking_layer(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Real of_layer,
                         const std::vector<char>& slip, Visit&& f) {
    if (!s.any_walls || context.solid_pairs.count(i) == 0) return;
    context.solid_pairs.of(i, [&](Index q, const Vec3& r, Real) {
        if (!slip[context.boundary.solid[q]]) each_layer_of(W, s, context, i, of_layer, q, r, f);
    });
}

/// Limit on the rate, times dt, at which layers pull a particle towards the velocity of a wall. The rate of a particle nearer to a wall
/// than d/3 would exceed it. Two explicit stages diverge above 2, of which the fluid needs up to 0.6 (viscous_step() allows for the fluid
/// alone).
inline Real sticking_share(Real rate) { return rate > 1 ? 1 / rate : Real(1); }

/// Sums for a Laplacian of f over a particle's neighbours, to which add_layers() adds the layers of the solids to which the fluid sticks.
struct StickingSums {
    Vec3 laplacian;  ///< sum m F (f_i - f_j), with the factor m of a pair
    Real trace;      ///< of -sum F r r^T
    Vec3 imbalance;  ///< sum F r

    /// @param own_factor m of the layers @param difference boundary particle -> f_i - f of the solid's surface
    /// @param rate (trace, sum |F| over the layers) -> rate for sticking_share(). A share leaves Laplacians of linear fields at 0.
    template <class Kernel, class Difference, class Rate>
    void add_layers(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Real of_layer,
                    const std::vector<char>& slip, Real own_factor, const Difference& difference, const Rate& rate) {
        const Vec3 of_fluid = laplacian, imbalance_of_fluid = imbalance;
        Real stiffness = 0;
        each_sticking_layer(W, s, context, i, of_layer, slip, [&](Index q, Real F, Real continued, const Vec3& to, Real distance) {
            laplacian += own_factor * F * continued * difference(q);
            trace -= F * distance * distance;
            imbalance += F * to;
            stiffness -= F * continued;
        });
        if (const Real share = sticking_share(rate(trace, stiffness)); share < 1) {
            laplacian = of_fluid + share * (laplacian - of_fluid);
            imbalance = imbalance_of_fluid + share * (imbalance - imbalance_of_fluid);
        }
    }
};

/// Writes the viscous force on no-slip solids to the ledgers. On a rigid surface the stress is mu du/dn, with u the velocity relative to
/// the rigid motion of the solid continued into the fluid.
/// @param mu i -> viscosity [Pa s] @param over_lattice 1/lattice_gradient() of the kernel W
template <class Kernel, class Viscosity>
void write_sticking(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Read<field::role> role,
                    Span<const Vec3> u, const Viscosity& mu, Real of_layer, Real over_lattice, const std::vector<char>& slip) {
    const StepContext& step = context.step;
    react(context, Push::viscous, role, step.volume * step.dt, [&](Index i) {
        Real trace = s.viscous.trace[i], stiffness = 0;
        each_sticking_layer(W, s, context, i, of_layer, slip, [&](Index, Real F, Real continued, const Vec3&, Real distance) {
            trace -= F * distance * distance, stiffness -= F * continued;
        });
        Real scale = mu(i) * s.laplacian_scale(step, i, trace, over_lattice);
        scale *= sticking_share(step.dt / step.rest_density * scale * stiffness);
        return [&, i, scale](Index q, const Vec3& r, Real) {
            const Solid& solid = context.solids.all[context.boundary.solid[q]];
            const Vec3 relative = u[i] - solid.pose.velocity_at(context.boundary.position[q] + r);
            Vec3 sum = Vec3::Zero();
            if (!slip[context.boundary.solid[q]])
                each_layer_of(W, s, context, i, of_layer, q, r,
                              [&](Index, Real F, Real continued, const Vec3&, Real) { sum += F * continued * relative; });
            return PushAt(scale * sum, r - step.spacing / 2 * context.boundary.normal[q]);
        };
    });
}

/// sum_j V (f_j - f_i) W'/r r^T over the fluid. Multiplied by L_i it is the gradient; rows are the components of f.
template <class Kernel>
Mat3 difference_sum(const Kernel& W, const FluidPairs& pairs, Index i, Real volume, const Vec3* f) {
    Real sum[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    const Vec3 own = f[i];
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[3][Pairs::Group::most], part[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
        group.gather(f, other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]);
            const Real x = F * group.r[0][l], y = F * group.r[1][l], z = F * group.r[2][l];
            const Real a = other[0][l] - own[0], b = other[1][l] - own[1], c = other[2][l] - own[2];
            part[0] += a * x, part[1] += a * y, part[2] += a * z;
            part[3] += b * x, part[4] += b * y, part[5] += b * z;
            part[6] += c * x, part[7] += c * y, part[8] += c * z;
        }
        for (int k = 0; k < 9; ++k) sum[k] += part[k];
    });
    Mat3 S;
    S << sum[0], sum[1], sum[2], sum[3], sum[4], sum[5], sum[6], sum[7], sum[8];
    return volume * S;
}

/// Scalar version.
template <class Kernel>
Vec3 difference_sum(const Kernel& W, const FluidPairs& pairs, Index i, Real volume, const Real* f) {
    Vec3 sum = Vec3::Zero();
    const Real own = f[i];
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real other[Pairs::Group::most], part[3] = {0, 0, 0};
        group.gather(f, other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]) * (other[l] - own);
            for (int a = 0; a < 3; ++a) part[a] += F * group.r[a][l];
        }
        sum += Vec3(part[0], part[1], part[2]);
    });
    return volume * sum;
}

/// Sums over the neighbours of one particle, of a vector f.
struct DifferenceSums {
    Vec3 laplacian = Vec3::Zero();  ///< sum V W'/r (f_i - f_j)
    Mat3 gradient = Mat3::Zero();   ///< sum V (f_j - f_i) W'/r r^T
    Vec3 smooth = Vec3::Zero();     ///< sum V W (f_j - f_i), with the kernel `smoothing` as W
};

/// Sums of several fields f.
/// @param smoothing a second kernel; nullptr: `smooth` stays 0
template <std::size_t fields, class Kernel, class Smoothing>
std::array<DifferenceSums, fields> difference_sums(const Kernel& W, const FluidPairs& pairs, Index i, Real volume,
                                                   const std::array<const Vec3*, fields>& f, const Smoothing& smoothing) {
    constexpr bool smooths = !std::is_null_pointer_v<Smoothing>;
    std::array<DifferenceSums, fields> all;
    const auto add = [&](const Pairs::Group& group, const Vec3* field, DifferenceSums& sums) {
        const Vec3 own = field[i];
        Real other[3][Pairs::Group::most], lap[3] = {0, 0, 0}, smooth[3] = {0, 0, 0}, S[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
        group.gather(field, other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Real F = W.slope(group.distance[l]);
            const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l];
            const Real a = own[0] - other[0][l], b = own[1] - other[1][l], c = own[2] - other[2][l];
            lap[0] += F * a, lap[1] += F * b, lap[2] += F * c;
            if constexpr (smooths) {
                const Real near = smoothing.value(group.distance[l]);
                smooth[0] -= near * a, smooth[1] -= near * b, smooth[2] -= near * c;
            }
            const Real p = F * a, q = F * b, t = F * c;
            S[0] -= p * x, S[1] -= p * y, S[2] -= p * z;
            S[3] -= q * x, S[4] -= q * y, S[5] -= q * z;
            S[6] -= t * x, S[7] -= t * y, S[8] -= t * z;
        }
        sums.laplacian += volume * Vec3(lap[0], lap[1], lap[2]);
        sums.smooth += volume * Vec3(smooth[0], smooth[1], smooth[2]);
        for (int k = 0; k < 9; ++k) sums.gradient(k / 3, k % 3) += volume * S[k];
    };
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        for (std::size_t k = 0; k < fields; ++k) add(group, f[k], all[k]);
    });
    return all;
}

/// Sums for Lap u at a particle near flat walls along which the fluid slips freely, over the fluid and its images behind these walls.
/// Without the images, the sums over one side contain a third to two thirds of Lap u.
struct MirroredSums {
    Vec3 laplacian = Vec3::Zero();  ///< sum_j V weight_j W'/r (u_i - u_j)
    Mat3 gradient = Mat3::Zero();   ///< gradient of u, exact for linear fields
    Real trace = 0;                 ///< of -sum_j V W'/r r r^T
    Vec3 imbalance = Vec3::Zero();  ///< sum_j V W'/r r [1/m]
};
/// @param of_images velocities of the images @param weight j -> factor of a neighbour in `laplacian`
template <class Kernel, class Weight>
MirroredSums mirrored_sums(const Kernel& W, const ProjectionSystem& s, const InteractionContext& context, Index i, Span<const Vec3> u,
                           Span<const Vec3> of_images, const Weight& weight) {
    Real lap[3]{}, S[9]{}, M[6]{}, plain[3]{};
    const Vec3 own = u[i];
    s.mirrors.groups_of(context.pairs, i, [&]<bool image>(const Pairs::Group& group, const Real* shares) {
        Real other[3][Pairs::Group::most], F[Pairs::Group::most], part[Pairs::Group::most];
        group.gather(image ? of_images.data() : u.data(), other);
        for (Index l = 0; l < group.padded(); ++l) {
            const Index j = group.other[l];
            part[l] = weight(image ? s.mirrors.owner(j) : j);
            F[l] = image ? (s.slides[j] ? shares[l] : 0) : 1;
        }
        Real lap_part[3]{}, S_part[9]{}, M_part[6]{}, plain_part[3]{};
        for (Index l = 0; l < group.padded(); ++l) {
            const Real f = F[l] * W.slope(group.distance[l]), x = group.r[0][l], y = group.r[1][l], z = group.r[2][l];
            const Real p = f * (own[0] - other[0][l]), q = f * (own[1] - other[1][l]), t = f * (own[2] - other[2][l]);
            lap_part[0] += part[l] * p, lap_part[1] += part[l] * q, lap_part[2] += part[l] * t;
            S_part[0] -= p * x, S_part[1] -= p * y, S_part[2] -= p * z;
            S_part[3] -= q * x, S_part[4] -= q * y, S_part[5] -= q * z;
            S_part[6] -= t * x, S_part[7] -= t * y, S_part[8] -= t * z;
            M_part[0] -= f * x * x, M_part[1] -= f * x * y, M_part[2] -= f * x * z;
            M_part[3] -= f * y * y, M_part[4] -= f * y * z, M_part[5] -= f * z * z;
            plain_part[0] += f * x, plain_part[1] += f * y, plain_part[2] += f * z;
        }
        for (int k = 0; k < 9; ++k) S[k] += S_part[k];
        for (int k = 0; k < 6; ++k) M[k] += M_part[k];
        for (int k = 0; k < 3; ++k) lap[k] += lap_part[k], plain[k] += plain_part[k];
    });
    const Real V = context.step.volume;
    MirroredSums all{V * Vec3(lap[0], lap[1], lap[2]), Mat3::Zero(), 0, V * Vec3(plain[0], plain[1], plain[2])};
    all.gradient << S[0], S[1], S[2], S[3], S[4], S[5], S[6], S[7], S[8];
    all.gradient *= V;
    Mat3d moment;
    moment << M[0], M[1], M[2], M[1], M[3], M[4], M[2], M[4], M[5];
    moment *= V;
    all.gradient = all.gradient * pseudo_inverse(moment, context.step.dimensions()).template cast<Real>();
    all.trace = static_cast<Real>(moment.trace());
    return all;
}
/// Velocities of the images behind walls.
inline Span<const Vec3> image_velocities(const ProjectionSystem& s, const InteractionContext& context, Span<const Vec3> u) {
    return s.mirrors.velocities(u, [&](Index solid) { return context.solids.all[solid].pose.velocity; });
}

/// Change of a vector f from x_i to x_i + move: gradient times move, plus |move|^2/(2 D) times the Laplacian. The second term is for the
/// curvature of f; without it crests would grow with every move.
/// @param sums of the kernel W
template <class Kernel>
Vec3 carried(const Kernel& W, const LinearSums& sums, const FluidPairs& pairs, Index i, Real volume, const Vec3* f, const Vec3& move) {
    const DifferenceSums of_f = difference_sums<1>(W, pairs, i, volume, {f}, nullptr)[0];
    const Mat3 G = of_f.gradient * sums.correction[i];
    return G * move + move.squaredNorm() / std::max(sums.trace[i], Real(0.1)) * (of_f.laplacian - G * sums.imbalance[i]);
}

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

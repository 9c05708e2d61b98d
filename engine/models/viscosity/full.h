#pragma once
/// Implicit viscosity in its full form, variational and matrix-free (docs/physics.md 4; Takahashi et al. 2015, mended).
///
/// Stages of a step, in order: Gravity, (forces), Kick, FullViscosity, (pressure), Move. It needs no density.
#include "engine/core/parallel.h"
#include "engine/geometry/solids.h"
#include "engine/math/solve.h"
#include "engine/particles/field.h"
#include "engine/particles/pairs.h"
#include "engine/particles/step.h"

namespace whorl {

namespace field {
struct viscous_acceleration {
    using type = Vec3;
    static constexpr std::string_view name = "viscous_acceleration", unit = "m/s^2", meaning = "viscous force of the last step over the mass";
};
}  // namespace field

struct FullViscosityOptions {
    /// tolerance: sqrt(r.B^-1 r) against sqrt(b.B^-1 b), B the 3x3 diagonal blocks, b the velocities before the solve relative to their mean.
    SolveLimits limits{1e-4, 500};
    bool correction = true;      ///< gradients exact for linear fields; false: as in the note, which slows free rotation down
    /// Of mu, against zig-zag modes that the central gradient does not see; vanishes for affine fields. It also makes up for part of what the central
    /// gradient loses of short waves: a wave of 32 particles decays 2.2 % too slowly with 0.05.
    Real penalty = Real(0.3);
    Real solid_factor = 1;       ///< on the solids' volumes, see models/boundary/wall.h
};

/// The operator of one step at fixed positions. With w_ij = V |W'(r)|/r (so that -w_ij r_ij = V grad W_ij), r_ij = x_i - x_j, u_ij = u_i - u_j:
///   G_i = sum_j w_ij u_ij r_ij^T M_i^+         velocity gradient; M_i = sum_j w_ij r_ij r_ij^T, M^+ its inverse where it has one
///   D_i = (P_i G_i + (P_i G_i)^T)/2            strain rate; P_i projects on the directions that the neighbours resolve
///   E(u) = sum_i m |u_i - u*_i|^2/2 + dt V sum_i mu_i (D_i:D_i + penalty 3/(sum_j w_ij r_ij^2) sum_j w_ij |u_ij - G_i r_ij|^2)
/// and A u = (dE/du)/m, without the terms of u*, solids and prescribed particles, which are the right-hand side. A is symmetric and positive
/// definite, because the force is the transpose of the gradient; a rigid motion costs no energy, so forces keep momentum and angular momentum.
/// V is the volume at rest, for an incompressible fluid the true one, also at the surface.
class ViscousOperator {
public:
    /// Coefficients for these positions.
    void set_up(const FullViscosityOptions& options, const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids,
                const SolidParticles& layer, const StepContext& step, Read<field::role> role, Read<field::viscosity> mu);

    /// y = A u; particles that are not free take part with 0 and get 0.
    void multiply(Span<const Vec3> u, Span<Vec3> y) const;
    /// The velocities' share in (dE/du)/m, without m (u - u*): u - (viscous part) over all, walls and prescribed particles with their velocities.
    void force(Span<const Vec3> u, Span<Vec3> y) const;
    /// z = B^-1 r with the true 3x3 diagonal blocks B of A.
    void precondition(Span<const Vec3> r, Span<Vec3> z) const;
    bool touches_wall() const { return touches_wall_; }
    Index size() const { return static_cast<Index>(K_.size()); }

private:
    using Vec4 = Eigen::Array<Real, 4, 1>;
    /// What the force pass reads of a neighbour: the columns of Q = 2 K P D M^+ - 2 c G, and c in the last place of the first.
    struct Stress {
        Vec4 column[3];
    };
    void strain(bool with_walls) const;
    void divergence(bool with_walls, Span<const Vec3> u, Span<Vec3> y) const;
    void load(Span<const Vec3> u, bool free_only) const;
    void set_up_wall(const FullViscosityOptions& options, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                     const StepContext& step);
    void set_up_blocks();

    const FluidPairs* pairs_ = nullptr;
    const SolidPairs* solid_pairs_ = nullptr;
    Column<Vec4> pair_;        ///< w r_ij and w of each pair
    Column<Vec4> wall_pair_;   ///< the same for solids, both times the stretch of the wall's shear; 0 where the fluid slips
    Column<Real> wall_stretch_;
    Column<Vec3> wall_velocity_;  ///< of the pair: stretch u_i - wall_velocity is the difference over it
    Column<Mat3> M_, P_;       ///< M^+ and P
    Column<Real> K_, c_;       ///< dt mu/rho_0 and the penalty's coefficient
    std::vector<char> free_, whole_;  ///< whole: P = 1
    Column<Mat3> block_inverse_;
    bool touches_wall_ = false;
    mutable Column<Vec4> u_;
    mutable Column<Stress> Q_;
};

/// u = argmin E, by conjugate gradients from u* + dt (last step's viscous acceleration). Where no solid and no prescribed particle takes part, momentum
/// and angular momentum are kept to round-off whatever the tolerance: the preconditioner works in the space without rigid motions.
class FullViscosity {
public:
    explicit FullViscosity(FullViscosityOptions options) : options_(options) {}
    void operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer, const StepContext& step,
                    StepReport& report, Read<field::role> role, Read<field::position> x, Read<field::viscosity> mu, Update<field::velocity> u,
                    Update<field::viscous_acceleration> last);

private:
    FullViscosityOptions options_;
    ViscousOperator operator_;
};

}  // namespace whorl

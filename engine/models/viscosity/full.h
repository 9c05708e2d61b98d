#pragma once
/// Implicit viscosity in its full form, variational and matrix-free (docs/physics.md 4; Takahashi et al. 2015, mended).
///
/// Stages of a step, in order: Gravity, (forces), Kick, FullViscosity, (pressure), Move. Corrected, it needs no density.
#include "engine/geometry/solids.h"
#include "engine/models/viscosity/implicit.h"
#include "engine/particles/pairs.h"

namespace whorl {

struct FullViscosityOptions {
    SolveLimits limits{1e-4, 500};  ///< see solve_implicit()
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
/// V is the volume at rest, for an incompressible fluid the true one, also at the surface. As in the note (correction = false): M^+ = V_i/V, P = 1, no
/// penalty, V_i = m/rho_i in the gradient and in the energy; a rotation then costs energy at a free surface.
class ViscousOperator final : public ImplicitOperator {
public:
    /// Coefficients for these positions.
    /// @param density [kg/m^3], of the form as in the note; empty: at rest
    void set_up(const FullViscosityOptions& options, const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids,
                const SolidParticles& layer, const StepContext& step, Read<field::role> role, Read<field::viscosity> mu, Span<const Real> density = {});

    void multiply(Span<const Vec3> u, Span<Vec3> y) const override;
    void force(Span<const Vec3> u, Span<Vec3> y) const override;
    void precondition(Span<const Vec3> r, Span<Vec3> z) const override { diagonal_.apply(r, z); }
    void divide_by_diagonal(Span<const Vec3> r, Span<Vec3> z) const override { diagonal_.apply(r, z); }
    bool touches_wall() const override { return touches_wall_; }
    bool rotations_are_free() const override { return corrected_; }
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
    BlockDiagonal diagonal_;
    bool touches_wall_ = false, corrected_ = true;
    mutable Column<Vec4> u_;
    mutable Column<Stress> Q_;
};

/// The stage of the corrected form: u = argmin E.
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

/// The stage of the form as in the note, which weights by the density.
class UncorrectedViscosity {
public:
    explicit UncorrectedViscosity(FullViscosityOptions options) : options_(options) { options_.correction = false; }
    void operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer, const StepContext& step,
                    StepReport& report, Read<field::role> role, Read<field::position> x, Read<field::density> rho, Read<field::viscosity> mu,
                    Update<field::velocity> u, Update<field::viscous_acceleration> last);

private:
    FullViscosityOptions options_;
    ViscousOperator operator_;
};

}  // namespace whorl

#pragma once
/// Implicit viscosity from forces along pairs (the Laplacian form; Weiler et al. 2018).
///
/// Stages of a step, in order: Gravity, (forces), Kick, PairwiseViscosity, (pressure), Move. It needs no density.
#include "engine/geometry/solids.h"
#include "engine/models/boundary/friction.h"
#include "engine/models/viscosity/implicit.h"
#include "engine/particles/pairs.h"

namespace whorl {

struct PairwiseViscosityOptions {
    SolveLimits limits{1e-4, 500};  ///< see solve_implicit()
};

/// A u = u_i + sum_j c_ij (u_ij . r_ij) r_ij,   c_ij = dt mu_ij/rho_0 2 (d + 2) f V |W'(r)|/r / (r^2 + 0.01 h^2),   mu_ij = 2 mu_i
/// mu_j/(mu_i + mu_j), with d = 3, h = R/2, and f = along_pairs_factor() near 1: backward Euler for the Laplacian `monaghan` of
/// models/viscosity/explicit.h. Each pair's force lies along the pair: momentum and angular momentum are kept. One pass a product, half of
/// what the full form takes; a rope of few particles across is too stiff with it.
class PairwiseOperator final : public ImplicitOperator {
public:
    void set_up(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                const StepContext& step, Read<field::role> role, Read<field::viscosity> mu);

    void multiply(Span<const Vec3> u, Span<Vec3> y) const override;
    void force(Span<const Vec3> u, Span<Vec3> y) const override;
    void precondition(Span<const Vec3> r, Span<Vec3> z) const override { diagonal_.apply(r, z); }
    void divide_by_diagonal(Span<const Vec3> r, Span<Vec3> z) const override { diagonal_.apply(r, z); }
    bool touches_wall() const override { return touches_wall_; }
    bool rotations_are_free() const override { return true; }
    Index size() const { return static_cast<Index>(free_.size()); }

private:
    const FluidPairs* pairs_ = nullptr;
    Column<Vec3> pair_;  ///< sqrt(c_ij) r_ij
    WallFriction friction_;
    Column<Mat3> wall_;        ///< sum over the solids of c_is stretch r_is r_is^T, and friction
    Column<Vec3> wall_force_;  ///< what the walls' velocities add
    BlockDiagonal diagonal_;
    std::vector<char> free_;
    bool touches_wall_ = false;
};

/// How stiff this form is for stretching along the axes of a cubic lattice and for shear between them, over the exact stiffness: 1 and 1
/// for dense neighbours, 1.45 and 0.70 with the cubic kernel and R = 2 d. Particles without order feel the mean, which is 1 within a few
/// per cent.
struct LatticeStiffness {
    double stretching = 1, shear = 1;
};
/// @param support, spacing [m]
LatticeStiffness pairwise_lattice_stiffness(KernelKind kernel, double support, double spacing);

/// The stage.
class PairwiseViscosity {
public:
    explicit PairwiseViscosity(PairwiseViscosityOptions options) : options_(options) {}
    void operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                    const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x, Read<field::viscosity> mu,
                    Update<field::velocity> u, Update<field::viscous_acceleration> last);

private:
    PairwiseViscosityOptions options_;
    PairwiseOperator operator_;
};

}  // namespace whorl

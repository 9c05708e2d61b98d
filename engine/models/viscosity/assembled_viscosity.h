#pragma once
/// Implicit viscosity in its full form, assembled in one sparse matrix: the 27 coefficients of the first source note (Takahashi et al.
/// 2015, supplement; docs/physics.md 14), corrected as in docs/physics.md 4. The matrix needs about ten times the memory of the
/// matrix-free operator (10 kB per particle at R = 2 d). So this form serves small scenes, and as a reference for that operator.
///
/// Stages of a step, in order: Density, VelocityGradient, Gravity, (forces), Kick, AssembledViscosity, (pressure), Move.
#include <memory>

#include "engine/models/viscosity/strain/curvature.h"
#include "engine/models/viscosity/viscous_operator.h"

namespace whorl {

/// The nine coefficients C(g, a) of a product of a kernel gradient g and a. Rows: equations of u, v, w. Columns: coefficients of u, v, w.
///   C(g, a)_ab = (g . a) delta_ab + g_b a_a
/// With omega_i = sum_j grad W_ij, alpha_i = sum_j a_ij, a_ij = V_i grad W_ij (in the printed form V_j grad W_ij), m^ = m dt and mu^ =
/// mu/rho^2, row i has without penalty the blocks
///   i itself (c_{u_i u_i} ... c_{w_i w_i}):        1 + m^ mu^_i C(omega_i, alpha_i)
///   neighbour j (c_{u_j u_i} ...):                 m^ [mu^_j C(grad W_ij, alpha_j) - mu^_i C(omega_i, a_ij)]
///   neighbour k of a neighbour (c_{u_k u_i} ...):  -m^ sum_j mu^_j C(grad W_ij, a_jk)
inline Mat3 nine_coefficients(const Vec3& gradW, const Vec3& a) {
    Mat3 c = a * gradW.transpose();
    c.diagonal().array() += gradW.dot(a);
    return c;
}

/// u_i + m^ sum_j (mu^_i Q_i + mu^_j Q_j) grad W_ij = u*_i,   Q_i = 2 T_i - grad u_i - (grad u_i)^T,  m^ = m dt,  mu^ = mu/rho^2,
/// T: strain rate that appears at the start of a rotating move (models/viscosity/strain/curvature.h).
/// The neighbours k of neighbours include i itself and i's neighbours j. Their coefficients add up in one entry. Solids are neighbours with
/// a known velocity. With a penalty the shear is continued into the solids and they mirror the stress, as in viscous_operator.h. Without
/// penalty (as printed) neither is done.
class AssembledOperator final : public ImplicitOperator {
public:
    /// @param before gradients of the velocities at the start of the step [1/s], which determine T; empty: T = 0
    void set_up(const ViscosityOptions& options, const InteractionContext& context, Read<field::role> role, Read<field::density> rho,
                Read<field::viscosity> mu, Span<const Mat3> before = {});

    void multiply(Span<const Vec3> u, Span<Vec3> y) const override;
    void force(Span<const Vec3> u, Span<Vec3> y) const override;
    void precondition(Span<const Vec3> r, Span<Vec3> z) const override { diagonal_.apply(r, z); }
    void divide_by_diagonal(Span<const Vec3> r, Span<Vec3> z) const override { diagonal_.apply(r, z); }
    bool touches_wall() const override { return touches_wall_; }
    bool rotations_are_free() const override { return false; }
    bool symmetric() const override { return !printed_; }
    void write_ledgers(const ImplicitStep& s, Span<const Vec3> u) const override;

    Index size() const { return static_cast<Index>(own_.size()); }
    /// Block of row i and column j; zero if there is none.
    Mat3 block(Index i, Index j) const;
    /// The note's c_{u_i u_i} ... c_{w_i w_i}, with the 1 of the mass and without the contribution of i as a neighbour k of its neighbours.
    const Mat3& printed_own(Index i) const { return own_[i]; }
    std::size_t bytes() const;

private:
    struct Gradients;
    /// Rows of 256 particles.
    struct Rows {
        std::vector<std::size_t> first;
        Column<Index> other;
        Column<Mat3> block;
    };
    static constexpr Index rows_size = 256;
    void assemble(const Gradients& g, const FluidPairs& pairs);
    void set_known_force(const Gradients& g, const InteractionContext& context, Span<const Mat3> before);
    Vec3 row_times(Index i, Span<const Vec3> u, bool free_only) const;

    std::vector<Rows> rows_;
    Column<Mat3> own_;
    Column<Vec3> known_force_;  ///< load from the velocities of walls and from T; empty: none
    BlockDiagonal diagonal_;
    std::vector<char> free_;
    bool touches_wall_ = false, printed_ = false;
    std::shared_ptr<const Gradients> gradients_;  ///< kept if a probe reads ledgers
    Column<Mat3> known_stress_;                   ///< stress of T and the solids' velocities alone; kept if a probe reads ledgers
};

/// Bytes of the matrix per particle, estimated from the number of lattice points within twice the kernel radius. @param reach (kernel
/// radius)/spacing
double assembled_bytes(double reach, int dimensions = 3);
/// Larger matrices are refused, because the same operator without a matrix needs about a tenth of the memory.
inline constexpr double most_assembled_bytes = 4e9;

/// The stage.
class AssembledViscosity {
public:
    explicit AssembledViscosity(ViscosityOptions options) : options_(options) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Read<field::density> rho, Read<field::viscosity> mu, Read<field::velocity_gradient> before, Update<field::velocity> u,
                    Update<field::viscous_acceleration> last) {
        operator_.set_up(options_, context, role, rho, mu, options_.printed ? Span<const Mat3>() : Span<const Mat3>(before.values));
        solve_implicit(operator_, options_.limits, {context, report, role, x, u, last});
    }

private:
    ViscosityOptions options_;
    AssembledOperator operator_;
};

}  // namespace whorl

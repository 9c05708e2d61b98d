#pragma once
/// Operator of the full implicit viscosity, variational and matrix-free (docs/physics.md 4; Takahashi et al. 2015, corrected). The set-up
/// is in viscous_operator.cpp, the product in viscous_operator_product.cpp, the coarse level in viscous_operator_coarse.cpp, free bodies in
/// viscous_operator_bodies.cpp.
#include "engine/models/boundary/friction.h"
#include "engine/models/viscosity/implicit_viscosity.h"
#include "engine/models/viscosity/strain/coarse_level.h"
#include "engine/models/viscosity/viscosity_options.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// The operator of one step at fixed positions. With w_ij = V |W'(r)|/r (so that -w_ij r_ij = V grad W_ij), r_ij = x_i - x_j,
/// u_ij = u_i - u_j:
///   G_i = sum_j w_ij u_ij r_ij^T M_i^+    velocity gradient; M_i = sum_j w_ij r_ij r_ij^T, M^+ its (pseudo-)inverse
///   D_i = (P_i G_i + (P_i G_i)^T)/2       strain rate; P_i projects on the directions that the neighbours resolve
///   T_i = P_i T P_i                       strain rate that appears at the start of a rotating move (strain/curvature.h)
///   E(u) = sum_i m |u_i - u*_i|^2/2
///          + dt V sum_i (1 - counted_i) mu_i (|D_i - T_i|^2 + penalty n/(sum_j w_ij r_ij^2) sum_j w_ij |u_ij - G_i r_ij|^2)
///          + dt V sum_i mu_i (u_i.F_i u_i/2 - u_i.f_i)
/// n is the number of dimensions. The last sum, with F_i and f_i, is the friction at walls with a slip length (models/boundary/friction.h);
/// counted_i is 0 at other particles. V is the volume at rest, which for an incompressible fluid is the true volume, also at the surface.
/// A u is (dE/du)/m without u*, T and the known velocities of solids and prescribed particles; these terms form the right-hand side. A is
/// symmetric and positive definite, because the force is the transpose of the gradient. A rigid motion dissipates no energy, so the forces
/// conserve momentum and angular momentum.
///
/// Uncorrected form (correction = false): M^+ = V_i/V and P = 1 in D_i, and V_i = m/rho_i in the gradient and in the energy. At a free
/// surface a rotation then dissipates energy. The penalty still uses the G_i above. D_i near no-slip solids also uses this G_i, unless
/// penalty is 0.
class ViscousOperator final : public ImplicitOperator {
public:
    /// Computes the coefficients for these positions.
    /// @param density densities, for the uncorrected form [kg/m^3]; empty: the rest density
    /// @param before gradients of the velocities at the start of the step [1/s], which determine T; empty: T = 0
    void set_up(const ViscosityOptions& options, const InteractionContext& context, Read<field::role> role, Read<field::viscosity> mu,
                Span<const Real> density = {}, Span<const Mat3> before = {});
    /// Frees the weights of the pairs until the next set_up().
    void release() { Column<Real>().swap(weight_); }
    /// Limits the viscosity of the penalty at a particle, until the next call, to the smallest of these values among the particle and its
    /// neighbours. @param soft [Pa s], must outlive set_up(); empty: the particle's own viscosity counts
    void limit_penalty(Span<const Real> soft) { soft_ = soft; }
    const ViscousBodies* bodies() const override { return bodies_.body.empty() ? nullptr : &bodies_; }

    void multiply(Span<const Vec3> u, Span<Vec3> y) const override;
    void force(Span<const Vec3> u, Span<Vec3> y) const override;
    /// z = B^-1 r, plus R Ac^-1 R^T r after use_coarse(). B: the 3x3 diagonal blocks, or 1 if dt nu/d^2 is small and no wall acts; R: the
    /// rigid motions of the groups; Ac = R^T A R.
    void precondition(Span<const Vec3> r, Span<Vec3> z) const override;
    void divide_by_diagonal(Span<const Vec3> r, Span<Vec3> z) const override;
    bool touches_wall() const override { return touches_wall_; }
    bool rotations_are_free() const override { return options_.correction; }
    void write_ledgers(const ImplicitStep& s, Span<const Vec3> u) const override;
    Index size() const { return static_cast<Index>(K_.size()); }
    /// gamma_i = sqrt(2 D:D) of the deviator of D_i - T_i [1/s]. @param u velocities [m/s], then those of the free bodies
    void shear_rates(Span<const Vec3> u, Span<Real> gamma) const;
    /// Largest dt nu_i over the particles [m^2].
    double largest_spread() const;

    /// R^T A R.
    SymmetricBlocks coarse_matrix(const RigidAggregates& groups) const;
    /// @param coarse must outlive its use; null: only the diagonal preconditions
    void use_coarse(const CoarseLevel* coarse) { coarse_ = coarse; }

private:
    /// Sixteen numbers in one or two vector registers. Lane 4 a + b belongs to component a of a velocity and component b of r_ij.
    struct alignas(64) Sixteen {
        Real lane[16];
        /// Sets the matrix in lanes 4 a + b, a fourth column in lanes 4 a + 3, and zeros in the last four.
        void set(const Mat3& matrix, const Vec3& beside = Vec3::Zero()) {
            for (int a = 0; a < 4; ++a)
                for (int b = 0; b < 4; ++b) lane[4 * a + b] = a == 3 ? 0 : b == 3 ? beside[a] : matrix(a, b);
        }
        Mat3 matrix() const { return Eigen::Map<const Eigen::Matrix<Real, 4, 4, Eigen::RowMajor>>(lane).topLeftCorner<3, 3>(); }
        Vec3 beside() const { return {lane[3], lane[7], lane[11]}; }
    };
    /// w r_ij, and the coefficient of the penalty's spring between i and j, 2 w (c_i + c_j).
    struct alignas(4 * sizeof(Real)) Pair {
        Vec3 wr;
        Real spring;
    };
    /// Calls f(j, pair) for the neighbours j of i. Only w is stored per pair.
    template <class F>
    void each_pair(Index i, F&& f) const {
        std::size_t k = pairs_->first[i];
        pairs_->groups_of(i, [&](const Pairs::Group& group) {
            Pair pair[Pairs::Group::most];
            for (Index l = 0; l < group.count; ++l, ++k) {
                const Real w = weight_[k];
                pair[l] = {Vec3(w * group.r[0][l], w * group.r[1][l], w * group.r[2][l]), w * (2 * (c_[i] + c_[group.other[l]]))};
            }
            for (Index l = 0; l < group.count; ++l) f(group.other[l], pair[l]);
        });
    }
    /// Effect of the solids near a particle, linear in its velocity.
    struct Wall {
        Pair near{Vec3::Zero(), 0};  ///< sum w stretch r, sum 2 c w stretch^2
        Sixteen moving{};            ///< gradient by the solids' own velocities; fourth column: force of their springs
    };
    /// dt nu F_i of walls with a slip length.
    Mat3 friction_coefficient(Index i) const { return dt_nu_[i] * friction_.coefficient(i); }
    void set_up_moments(const ViscosityOptions& options, const StepContext& step, Read<field::role> role, Read<field::viscosity> mu,
                        Span<const Real> density);
    void set_up_wall(const ViscosityOptions& options, const InteractionContext& context);
    void set_up_curvature(Span<const Mat3> before, Real dt);
    void set_up_blocks(const ViscosityOptions& options, double d);
    void spread(Span<const Vec3> u, bool free_only) const;
    template <class F>
    void each_strain(Span<const Vec3> u, bool with_known, const F& f) const;
    void stress(Span<const Vec3> u, bool with_known) const;
    void divergence(Span<const Vec3> u, Span<Vec3> y, bool free_only) const;
    void set_up_bodies(const ViscosityOptions& options, const InteractionContext& context);
    void set_up_body_blocks();
    struct CoarseRows;
    /// Subtracts the bodies' velocities from the sums at i.
    void subtract_body_velocities(Index i, Span<const Vec3> u, Mat3& A, Vec3& own) const;
    void set_body_forces(Index i, Span<const Vec3> u, const Vec3& own_velocity, const Mat3& Q) const;
    void sum_bodies(Span<const Vec3> u, Span<Vec3> y) const;

    ViscosityOptions options_;
    int dimensions_ = 3;
    const FluidPairs* pairs_ = nullptr;
    Span<const Real> soft_;
    Column<Real> weight_;  ///< w of each pair
    Column<Pair> wr_;      ///< sums of w r_ij over fluid and solids
    WallFriction friction_;
    Column<Real> dt_nu_;         ///< dt mu/rho_0; valid if there is friction
    Column<Wall> wall_;          ///< empty: there are no solids
    Column<Mat3d> wall_moment_;  ///< part of the solids in M
    Column<Sixteen> M_, P_;      ///< M^+ and P
    Column<Sixteen> curvature_;  ///< 2 P T; empty: none
    Column<Real> K_, c_;         ///< K: (1 - counted) dt mu/rho_0; c: coefficient of the penalty
    /// whole_: 0: some directions are unresolved. 1: P = 1. 2: P = 1 and D_i has the uncorrected form; P_ then contains the penalty's M^+.
    std::vector<char> free_, whole_;
    BlockDiagonal diagonal_;
    mutable ViscousBodies bodies_;
    std::vector<Mat3d> body_blocks_;  ///< inverses of the 3x3 diagonal blocks of the bodies' entries
    bool touches_wall_ = false;
    const CoarseLevel* coarse_ = nullptr;
    mutable Column<Sixteen> u_, Q_;  ///< the last four lanes contain the position and -2 c
    mutable Column<Sixteen> own_;    ///< part of y without the neighbours' stresses; each component is the sum of four lanes
};

}  // namespace whorl

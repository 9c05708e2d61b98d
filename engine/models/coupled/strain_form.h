#pragma once
/// The quadratic form that the coupled solve minimises, over the particles' rows (docs/physics.md 4 and 5, made incompressible).
///
/// Per unit mass, lengths in spacings, with K_i = mu_i dt/(rho d^2):
///
///   E(u) = sum_i |u_i - u*_i|^2 / 2 + K_i [ |D_i - T_i|^2 + Lambda_i/2 (tr D_i - s_i)^2 ] - q_i tr D_i + c_i S_i + c'_i S'_i
///
///   A_i = sum_j w (u_j - u_i) r^T      G_i = A_i M_i+      D_i = (P_i G_i + G_i^T P_i)/2
///   S_i = sum_j w |u_j - u_i|^2 - A_i:G_i                        what the linear field does not explain
///   S'_i = sum_j w/r^2 ((u_j - u_i).r - r.G_i r)^2               the same along the pair
///
/// T_i is the curvature of the move (models/strain/curvature.h), s_i the change of volume that is asked for.
/// D is exact where all directions are resolved and zero for a rigid rotation even in a single file of particles. The forces are the exact
/// derivative of E, pair by pair opposite: momentum is conserved to round-off.
#include "engine/math/conjugate_gradients.h"
#include "engine/models/coupled/strain_terms.h"

namespace whorl {

/// G d^-1 of every row [1/s] @param spacing d [m]
void velocity_gradients(const CoupledRows& rows, Real spacing, Span<const Vec3> u, Span<Mat3> G);  // walls move

class StrainForm {
public:
    /// @param viscosity mu [Pa s] of each particle @param dt [s] @param density rho [kg/m^3] @param spacing d [m]
    /// @param counted part of a particle's volume whose shear is the friction's (ContactFriction::counted); empty: none
    void set(const CoupledRows& rows, Span<const Real> viscosity, Span<const Real> counted, Real dt, Real density, Real spacing,
             const CoupledOptions& options);

    /// Gives its memory back until the next set().
    void release() { Column<CoefficientLanes>().swap(by_slice_), Column<Vec4>().swap(forces_); }

    /// Adds sum_i u_i.F_i u_i/2 to E, F the coefficients; empty: nothing. They must outlive the use.
    void set_friction(Span<const Mat3> coefficient) { friction_ = coefficient; }
    Mat3 friction(Index i) const { return friction_.empty() ? Mat3(Mat3::Zero()) : friction_[i]; }

    /// y = (1 + K) u: mass, strain and friction, over the mass [m/s].
    /// @param moving walls have their velocities, else none
    void apply(Span<const Vec3> u, Span<Vec3> y, bool moving = false) const;
    /// y_i = free(i, ((1 + K) u)_i): free takes out what is prescribed. @param y not u itself @returns u.y
    template <class F>
    double apply(Span<const Vec3> u, Span<Vec3> y, const F& free) const {
        find_forces(u);
        return parallel_sum(rows_->size(), [&](Index i) {
            y[i] = free(i, applied(u, i));
            return dot_entry(u[i], y[i]);
        });
    }
    /// y_i += sum over rows of P (q + 2 K d T) M+ (w r): the forces of -q tr D - 2 K d T:D [m/s].
    /// @param T symmetric [1/s]; empty: none
    void add_stress(Span<const Real> q, Span<const Mat3> T, Span<Vec3> y) const;
    /// The forces on walls alone, without a y: of apply(u, y, true) and of add_stress().
    void find_wall_forces(Span<const Vec3> u) const { find_forces(u, true, true); }
    void find_wall_forces(Span<const Real> q, Span<const Mat3> T) const { find_stress(q, T, true); }
    /// Calls f(wall, force on it) for what the last of these four found [m/s].
    template <class F>
    void each_wall_force(const F& f) const {
        for (const RowBlock& block : rows_->blocks)
            for (std::size_t k = 0; k < block.walls.size(); ++k) {
                const Vec4& v = forces_[block.place + block.touched.size() + k];
                f(block.walls[k], Vec3(v.v[0], v.v[1], v.v[2]));
            }
    }
    /// velocity_gradients() of its rows.
    void gradient(Span<const Vec3> u, Span<Mat3> G) const { velocity_gradients(*rows_, spacing_, u, G); }
    /// The 3x3 diagonal blocks of 1 + K (to a few per cent where directions are unresolved).
    void diagonal(Span<Mat3> B) const;

    /// tr D of the particle, given its gradient [1/s].
    Real divergence(Index i, const Mat3& G) const;
    StrainCoefficients coefficients(Index i) const {
        const RowBlock& block = rows_->block_of(i);
        const Index lane = block.lane[i - block.begin];
        return by_slice_[block.first_slice + static_cast<std::size_t>(lane / lane_count)].of(lane % lane_count);
    }
    /// Of the k-th slice of a block.
    const CoefficientLanes& coefficients(const RowBlock& block, std::size_t k) const { return by_slice_[block.first_slice + k]; }
    const CoupledRows& rows() const { return *rows_; }

private:
    /// Forces of the product and of stresses. @param at_walls only those of blocks with walls
    void find_forces(Span<const Vec3> u, bool moving = false, bool at_walls = false) const;
    void find_stress(Span<const Real> q, Span<const Mat3> T, bool at_walls) const;
    /// (1 + K) u of particle i, given the forces.
    Vec3 applied(Span<const Vec3> u, Index i) const {
        const Vec4 f = rows_->gathered(forces_, i)[0];
        Vec3 y = u[i] + Vec3(f.v[0], f.v[1], f.v[2]);
        if (!friction_.empty()) y += friction_[i] * u[i];
        return y;
    }
    Lanes33 resolved_part(const RowBlock& block, const RowSlice& slice, const Lanes33& m) const;

    const CoupledRows* rows_ = nullptr;
    Column<CoefficientLanes> by_slice_;
    Span<const Mat3> friction_;
    Real spacing_ = 1;
    mutable Column<Vec4> forces_;  ///< one a touched particle of each block
};

}  // namespace whorl

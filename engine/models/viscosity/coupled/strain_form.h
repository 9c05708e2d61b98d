#pragma once
/// The quadratic form that the coupled solve minimises, over the particles' rows (docs/physics.md 4 and 5, made incompressible).
///
/// Per unit mass, lengths in spacings, with K_i = mu_i dt/(rho d^2):
///
///   E(u) = sum_i |u_i - u*_i|^2 / 2 + K_i [ |D_i - T_i|^2 + Lambda_i/2 (tr D_i - s_i)^2 ] - q_i tr D_i + c_i S_i + c'_i S'_i
///
///   A_i = sum_j w (u_j - u_i) r^T      G_i = A_i M_i+      D_i = (P_i G_i + G_i^T P_i)/2
///   S_i = sum_j w |u_j - u_i|^2 - A_i:G_i                        residual of the linear fit
///   S'_i = sum_j w/r^2 ((u_j - u_i).r - r.G_i r)^2               the same along the pair
///
/// u* are the velocities before the solve; r, w, M+ and P are those of coupled_rows.h. T_i is the strain rate that appears at the start of
/// a rotating move (models/viscosity/strain/curvature.h), s_i the requested rate of volume change, q_i the multiplier (pressure). K_i
/// Lambda_i is the bulk viscosity; c_i and c'_i are penalties. D is exact if all directions are resolved, and zero for a rigid rotation
/// even in a single file of particles. The forces are the exact derivative of E and opposite in each pair, so momentum is conserved to
/// round-off.
///
/// Free bodies: velocity v and angular velocity w of each are two more entries of u after those of the particles. E also has the energy
/// (M |v - v*|^2 + (w - w*).I (w - w*))/(2 m) of the body, with M and I its mass and tensor of inertia and m the mass of a particle. The
/// points of its surface that hold particles (WallPoint) have the velocity v + w x arm. Their forces and torques are the derivative by v
/// and w, so the momentum of fluid and bodies together is conserved.
#include "engine/math/block_cholesky.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/viscosity/coupled/coupled_rows.h"
#include "engine/models/viscosity/viscous_bodies.h"

namespace whorl {

/// Coefficients of a particle's energy.
struct StrainCoefficients {
    Real shear = 0;  ///< 2 K
    /// K Lambda, reduced such that an unresolved lateral direction is stress-free. A single file of particles then has Trouton's viscosity
    /// 3 mu and does not lock.
    Real bulk = 0;
    Real smooth = 0;  ///< 2 c
    Real pair = 0;    ///< 2 c'
};

/// The coefficients of a slice's rows.
struct CoefficientLanes {
    Lanes shear{}, bulk{}, smooth{}, pair{};
    void set(Index lane, const StrainCoefficients& c) {
        shear[lane] = c.shear, bulk[lane] = c.bulk, smooth[lane] = c.smooth, pair[lane] = c.pair;
    }
    StrainCoefficients of(Index lane) const { return {shear[lane], bulk[lane], smooth[lane], pair[lane]}; }
};

/// A += v b^T
inline void add_outer(const Lanes3& v, const Lanes3& b, Lanes33& A) {
    A.m[0][0] += v.x * b.x, A.m[0][1] += v.x * b.y, A.m[0][2] += v.x * b.z;
    A.m[1][0] += v.y * b.x, A.m[1][1] += v.y * b.y, A.m[1][2] += v.y * b.z;
    A.m[2][0] += v.z * b.x, A.m[2][1] += v.z * b.y, A.m[2][2] += v.z * b.z;
}

/// sum w/r^2 (r.D r) r r^T
inline SymmetricLanes contract(const FourthMoment& f, const SymmetricLanes& D) {
    const Lanes g[6] = {D.xx, D.yy, D.zz, D.xy + D.xy, D.xz + D.xz, D.yz + D.yz};
    const auto number = [&](int k) {
        Lanes sum = f.of(k, 0) * g[0];
        for (int l = 1; l < 6; ++l) sum += f.of(k, l) * g[l];
        return sum;
    };
    return {number(0), number(1), number(2), number(3), number(4), number(5)};
}

/// P (2 K D + K Lambda tr D), with D in the resolved directions: dE/dG of the strain and bulk terms.
/// @param resolved_of resolved_of(m) is P m of each lane; not called if all directions are resolved
template <class Resolved>
Lanes33 stress(const Lanes33& G, const CoefficientLanes& c, bool resolved, const Resolved& resolved_of) {
    const auto of = [&](const SymmetricLanes& D) {
        const Lanes volume = c.bulk * (D.xx + D.yy + D.zz);
        return whole(
            {c.shear * D.xx + volume, c.shear * D.yy + volume, c.shear * D.zz + volume, c.shear * D.xy, c.shear * D.xz, c.shear * D.yz});
    };
    if (resolved) return of(symmetric(G));
    const Lanes33 S = of(symmetric(resolved_of(G)));
    return resolved_of(S);
}

/// Q = (P S - H) M+ - 2 c G, the row's part of dE/dA: S the stress, H = 2 c' sum w/r^2 ((u_j - u_i).r - r.D r) r r^T.
/// @param along sum w/r^2 ((u_j - u_i).r) r r^T
template <class Resolved>
Lanes33 row_force(const Lanes33& G, const SymmetricLanes& along, const CoefficientLanes& c, const SymmetricLanes& inverse_moment,
                  const FourthMoment& fourth, bool resolved, const Resolved& resolved_of) {
    const SymmetricLanes linear = contract(fourth, symmetric(G));
    const Lanes33 H = whole({c.pair * (along.xx - linear.xx), c.pair * (along.yy - linear.yy), c.pair * (along.zz - linear.zz),
                             c.pair * (along.xy - linear.xy), c.pair * (along.xz - linear.xz), c.pair * (along.yz - linear.yz)});
    Lanes33 Q = stress(G, c, resolved, resolved_of);
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) Q.m[a][b] -= H.m[a][b];
    Q = Q * inverse_moment;
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) Q.m[a][b] -= c.smooth * G.m[a][b];
    return Q;
}

/// G = (velocity gradient in spacings)/d of every row [1/s]. Walls have their velocities. @param spacing d [m]
void velocity_gradients(const CoupledRows& rows, Real spacing, Span<const Vec3> u, Span<Mat3> G);

class StrainForm {
public:
    /// @param viscosity mu [Pa s] of each particle @param dt [s] @param density rho [kg/m^3] @param spacing d [m]
    void set(const CoupledRows& rows, Span<const Real> viscosity, Real dt, Real density, Real spacing, const CoupledOptions& options);

    /// Limits the viscosity of a particle's penalties, until the next call, to the smallest of these values among the particle and its
    /// neighbours. @param soft [Pa s], must outlive set(); empty: the particle's own viscosity counts
    void limit_penalties(Span<const Real> soft) { soft_ = soft; }
    /// Frees the memory until the next set().
    void release() { Column<CoefficientLanes>().swap(by_slice_), Column<Vec4>().swap(forces_); }

    /// Adds sum_i u_i.F_i u_i/2 to E, with F the coefficients; empty: no friction. They must outlive the use.
    void set_friction(Span<const Mat3> coefficient) { friction_ = coefficient; }
    /// Adds the bodies to the unknowns. It must outlive the use. @param bodies the inertia of all free bodies, empty: there are none
    void set_bodies(const ViscousBodies& bodies);
    const ViscousBodies* bodies() const { return bodies_; }  ///< null: there are none
    Real spacing() const { return spacing_; }
    Mat3 friction(Index i) const { return friction_.empty() ? Mat3(Mat3::Zero()) : friction_[i]; }

    /// y = (1 + K) u: mass, strain and friction, per mass [m/s].
    /// @param moving whether walls have their velocities; else they are at rest
    void apply(Span<const Vec3> u, Span<Vec3> y, bool moving = false) const;
    /// y_i = free(i, ((1 + K) u)_i), where free() removes prescribed components. @param y must not be u @returns u.y
    template <class F>
    double apply(Span<const Vec3> u, Span<Vec3> y, const F& free) const {
        find_forces(u);
        const double product = parallel_sum(rows_->size(), [&](Index i) {
            y[i] = free(i, applied(u, i));
            return dot_entry(u[i], y[i]);
        });
        return bodies_ == nullptr ? product : product + apply_to_bodies(u, y);
    }
    /// y_i += sum over rows of P (q + 2 K d T) M+ (w r): the forces of -q tr D - 2 K d T:D [m/s].
    /// @param T symmetric [1/s]; empty: none
    void add_stress(Span<const Real> q, Span<const Mat3> T, Span<Vec3> y) const;
    /// Computes only the forces on walls: those of apply(u, y, true) and of add_stress().
    void find_wall_forces(Span<const Vec3> u) const { find_forces(u, true, true); }
    void find_wall_forces(Span<const Real> q, Span<const Mat3> T) const { find_stress(q, T, true); }
    /// Calls f(block, wall, force on it [m/s]) with the forces of the last apply(), add_stress() or find_wall_forces().
    template <class F>
    void each_wall_force(const F& f) const {
        for (const RowBlock& block : rows_->blocks)
            for (std::size_t k = 0; k < block.walls.size(); ++k) {
                const Vec4& v = forces_[block.place + block.touched.size() + k];
                f(block, block.walls[k], Vec3(v.v[0], v.v[1], v.v[2]));
            }
    }
    /// velocity_gradients() of these rows.
    void gradient(Span<const Vec3> u, Span<Mat3> G) const { velocity_gradients(*rows_, spacing_, u, G); }
    /// 3x3 diagonal blocks of 1 + K (to a few per cent if directions are unresolved), and a 6x6 block for each body.
    void diagonal(Span<Mat3> B, std::vector<SymmetricBlocks::Block>* of_bodies = nullptr) const;

    /// tr D of a particle with the gradient G [1/s].
    Real divergence(Index i, const Mat3& G) const;
    StrainCoefficients coefficients(Index i) const {
        const RowBlock& block = rows_->block_of(i);
        const Index lane = block.lane[i - block.begin];
        return by_slice_[block.first_slice + static_cast<std::size_t>(lane / lane_count)].of(lane % lane_count);
    }
    /// Coefficients of the k-th slice of a block.
    const CoefficientLanes& coefficients(const RowBlock& block, std::size_t k) const { return by_slice_[block.first_slice + k]; }
    const CoupledRows& rows() const { return *rows_; }

private:
    /// Computes the forces of the product and of stresses. @param at_walls only those of slices with walls
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
    /// y = M u + forces of the rows, for the entries of the bodies. @returns u.y of these entries
    double apply_to_bodies(Span<const Vec3> u, Span<Vec3> y) const;
    /// Adds the last forces on the bodies' surfaces to their entries of y.
    void add_wall_forces(Span<Vec3> y) const;

    /// A point on the surface of a body.
    struct BodyPoint {
        std::size_t place;  ///< in forces_
        Index body;
        Vec3 arm;
    };

    const CoupledRows* rows_ = nullptr;
    Column<CoefficientLanes> by_slice_;
    Span<const Mat3> friction_;
    Span<const Real> soft_;
    const ViscousBodies* bodies_ = nullptr;
    std::vector<BodyPoint> body_points_;
    Real spacing_ = 1;
    mutable Column<Vec4> forces_;  ///< one per touched particle of each block
};

}  // namespace whorl

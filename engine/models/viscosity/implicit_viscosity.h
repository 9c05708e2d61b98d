#pragma once
/// Solve of one step, common to the implicit viscosities.
#include "engine/core/column.h"
#include "engine/math/solve.h"
#include "engine/models/viscosity/viscous_bodies.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

namespace field {
struct viscous_acceleration {
    using type = Vec3;
    static constexpr std::string_view name = "viscous_acceleration", unit = "m/s^2",
                                      meaning = "viscous force of the last step over the mass";
};
}  // namespace field

struct ImplicitStep;

/// A is the linear part of (dE/du)/m at fixed positions, with E(u) = sum_i m |u_i - u*_i|^2/2 + (viscous energy) and u* the velocities
/// before the solve. A is symmetric and positive definite unless symmetric() is false. Particles that are not free keep their velocity.
class ImplicitOperator {
public:
    virtual ~ImplicitOperator() = default;
    /// y = A u; particles that are not free count with 0 and get 0.
    virtual void multiply(Span<const Vec3> u, Span<Vec3> y) const = 0;
    /// y = (dE/du)/m + u*, that is, u - dt (viscous force)/m. It includes the term T (strain/curvature.h), and the known velocities of
    /// walls and prescribed particles.
    virtual void force(Span<const Vec3> u, Span<Vec3> y) const = 0;
    /// Sets z to an approximation of A^-1 r that is linear in r, symmetric and positive definite on the free particles; z = 0 for others.
    virtual void precondition(Span<const Vec3> r, Span<Vec3> z) const = 0;
    /// z = B^-1 r with the true 3x3 diagonal blocks B of A, or another B that is as good for the norm of the residual.
    virtual void divide_by_diagonal(Span<const Vec3> r, Span<Vec3> z) const = 0;
    virtual bool touches_wall() const = 0;
    /// false: A is not symmetric, so BiCGSTAB replaces conjugate gradients.
    virtual bool symmetric() const { return true; }
    /// Whether a rigid rotation of the fluid dissipates no energy.
    virtual bool rotations_are_free() const = 0;
    /// Free bodies among the unknowns, each with two entries (velocity, angular velocity) after those of the particles; null: none.
    virtual const ViscousBodies* bodies() const { return nullptr; }
    /// Adds the impulses that the fluid exerts on solids to the ledgers of those solids that are not unknowns. @param u velocities of the
    /// last force()
    virtual void write_ledgers(const ImplicitStep& s, Span<const Vec3> u) const = 0;
};

/// Input of the stage of an implicit viscosity.
struct ImplicitStep {
    const InteractionContext& context;
    StepReport& report;
    Read<field::role> role;
    Read<field::position> x;
    Update<field::velocity> u;
    Update<field::viscous_acceleration> last;
};

/// Velocities after the solve and their changes, free bodies included.
struct ImplicitSolution {
    Column<Vec3> u, change;
};

/// u = argmin E, by conjugate gradients from u* + dt (last step's viscous acceleration). If no solid and no prescribed particle acts,
/// momentum is conserved to round-off for any tolerance, because the preconditioner works in the space without rigid motions. Angular
/// momentum is then conserved, too, if rotations_are_free().
/// @param limits tolerance for sqrt(r.z)/sqrt(b.B^-1 b), with r the residual and z = precondition(r). b: velocities before the solve
/// relative to their mean, plus the loads of walls and prescribed particles. If viscosity changed these velocities by less than a hundredth
/// in the last step, the tolerance is reduced in proportion, but not below 0.03 of its value.
/// Sets s.last, from which the next step guesses, but neither velocities nor ledgers.
ImplicitSolution find_solution(const ImplicitOperator& A, const SolveLimits& limits, const ImplicitStep& s);
/// Sets the velocities of particles and bodies, and writes the ledgers. @param A the operator that the solution belongs to
void take_solution(const ImplicitOperator& A, const ImplicitStep& s, const ImplicitSolution& solution);
inline void solve_implicit(const ImplicitOperator& A, const SolveLimits& limits, const ImplicitStep& s) {
    take_solution(A, s, find_solution(A, limits, s));
}

/// Inverse of the 3x3 diagonal blocks B: z = B^-1 r for the free particles, 0 for the others.
class BlockDiagonal {
public:
    /// Takes the blocks B and stores their inverses.
    void set(Column<Mat3> B, std::vector<char> free);
    void apply(Span<const Vec3> r, Span<Vec3> z) const;

private:
    Column<Mat3> inverse_;
    std::vector<char> free_;
};

/// Momentum and angular momentum of equal particles, per mass of one particle.
struct Momenta {
    Vec3d momentum = Vec3d::Zero(), turning = Vec3d::Zero();
    void operator+=(const Momenta& o) { momentum += o.momentum, turning += o.turning; }
    Momenta operator-() const { return {-momentum, -turning}; }
};
/// @param centre reference point of the angular momentum [m]
Momenta momenta_of(Span<const Vec3> x, Span<const Vec3> u, const Vec3d& centre);

/// Rigid motion (mean translation and rotation) of a velocity field. The field minus this motion has neither momentum nor angular momentum.
class RigidMotions {
public:
    /// For no particles: removes and adds nothing.
    RigidMotions() = default;
    /// @param turning false if the domain is periodic, where a rotation is not a rigid motion
    /// @param bodies each with two entries (velocity, angular velocity) after those of the particles; null: none
    RigidMotions(Span<const Vec3> x, bool turning, const ViscousBodies* bodies = nullptr);
    /// Removes the rigid motion from a velocity field.
    void remove(Span<Vec3> u) const;
    /// Removes from forces (per mass of a particle) their rigid part: mass times a rigid motion.
    void remove_force(Span<Vec3> f) const;
    /// Adds to u the rigid motion of another velocity field.
    void add(Span<const Vec3> v, Span<Vec3> u) const;
    /// Adds to u the rigid motion with these momenta, about the origin.
    void add(const Momenta& momenta, Span<Vec3> u) const;

private:
    Momenta sum(Span<const Vec3> u, bool masses) const;
    void add(Span<Vec3> u, const Momenta& momenta, bool masses) const;

    Span<const Vec3> x_;
    const ViscousBodies* bodies_ = nullptr;
    double mass_ = 0;  ///< (total mass)/(mass of a particle)
    Vec3d centre_ = Vec3d::Zero();
    Mat3d inverse_inertia_ = Mat3d::Zero();  ///< pseudo-inverse, because particles on a line have no inertia about it
};

}  // namespace whorl

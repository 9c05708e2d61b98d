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

/// The derivative of E(u) = sum_i m |u_i - u*_i|^2/2 + (viscous energy) at fixed positions, over m: symmetric and positive definite.
/// Particles that are not free keep their velocity.
class ImplicitOperator {
public:
    virtual ~ImplicitOperator() = default;
    /// y = A u; particles that are not free count with 0 and get 0.
    virtual void multiply(Span<const Vec3> u, Span<Vec3> y) const = 0;
    /// The part of (dE/du)/m that depends on the velocities, without u*: u - dt (viscous force)/m. It includes the curvature, and walls and
    /// prescribed particles with their velocities.
    virtual void force(Span<const Vec3> u, Span<Vec3> y) const = 0;
    /// z approximates A^-1 r, with an operator that is symmetric and positive definite on the free particles; z = 0 for others.
    virtual void precondition(Span<const Vec3> r, Span<Vec3> z) const = 0;
    /// z = B^-1 r with the true 3x3 diagonal blocks B of A, for the norm of the residual.
    virtual void divide_by_diagonal(Span<const Vec3> r, Span<Vec3> z) const = 0;
    virtual bool touches_wall() const = 0;
    /// false: A is not symmetric, so BiCGSTAB replaces conjugate gradients.
    virtual bool symmetric() const { return true; }
    /// Whether the rotation of a free body costs no energy.
    virtual bool rotations_are_free() const = 0;
    /// Free bodies among the unknowns, with two entries each after the particles'. Null: there are none.
    virtual const ViscousBodies* bodies() const { return nullptr; }
    /// Writes the impulses of the fluid on solids that are not unknowns to their ledgers. @param u velocities of the last force()
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

/// u = argmin E, by conjugate gradients from u* + dt (last step's viscous acceleration). If no solid and no prescribed particle acts,
/// momentum (and angular momentum, if rotations are free) is conserved to round-off for any tolerance, because the preconditioner works in
/// the space without rigid motions.
/// @param limits tolerance for sqrt(r.z), z = precondition(r), over sqrt(b.B^-1 b), with b the velocities before the solve relative to
/// their mean. It applies to steps in which viscosity changes these by a hundredth, and is smaller if it changes them less
void solve_implicit(const ImplicitOperator& A, const SolveLimits& limits, const ImplicitStep& s);

/// Inverse of the 3x3 diagonal blocks: z = B^-1 r for the free particles, 0 for the others.
class BlockDiagonal {
public:
    /// @param B written: inverted in place
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

/// Mean translation and rotation of a velocity field; the field without them has neither momentum nor angular momentum.
class RigidMotions {
public:
    /// For no particles: removes and adds nothing.
    RigidMotions() = default;
    /// @param turning false if the domain is periodic, where a rotation is not a rigid motion
    /// @param bodies with two entries each after the particles'; null: none
    RigidMotions(Span<const Vec3> x, bool turning, const ViscousBodies* bodies = nullptr);
    /// Removes the rigid motion from a velocity field.
    void remove(Span<Vec3> u) const;
    /// Removes from forces (per mass of a particle) the part that makes a rigid motion: mass times rigid motion.
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
    double mass_ = 0;  ///< total mass over that of a particle
    Vec3d centre_ = Vec3d::Zero();
    Mat3d inverse_inertia_ = Mat3d::Zero();  ///< pseudo-inverse: a line of particles has no rotation about itself
};

}  // namespace whorl

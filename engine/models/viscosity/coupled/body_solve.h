#pragma once
/// Free bodies in the coupled solve: their velocities are unknowns, and contact with other solids restricts these.
///
/// While contacts hold, the velocities v of the bodies stay in the null space of J, the relative velocities at the held contacts. The
/// projection on it is Pi = 1 - M^-1 J^T (J M^-1 J^T)^-1 J, with M the masses and tensors of inertia (geometry/body_contact.h). The solve
/// then has the matrix Pi^T A Pi.
#include "engine/geometry/body_contact.h"
#include "engine/models/viscosity/viscous_bodies.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

class BodySolve {
public:
    ViscousBodies inertia;  ///< of all free bodies, without touches

    /// Reads the bodies' velocities and finds their contacts. @returns the number of their entries in the vectors of the solve
    std::size_t begin(const InteractionContext& context);
    bool any() const { return !inertia.body.empty(); }

    // In the following, `entries` are the part of a vector that belongs to the bodies: velocity and angular velocity [m/s, 1/s], or
    // impulse and angular impulse over the mass of a particle.

    /// Sets the impulses M v of the velocities before the solve.
    void momenta(Span<Vec3> entries) const;
    /// Sets the first guess: the velocities before the solve, without the fall of this step. @param fall dt g [m/s]
    void guess(const Vec3& fall, Span<Vec3> entries) const;
    /// Lets go of all contacts.
    void release() { in_contact_ = false; }
    bool in_contact() const { return in_contact_; }
    /// Holds the contacts that restrict these velocities. @param change set to the change by contact @returns whether there are any
    bool touch(Span<const Vec3> velocities, Span<Vec3> change);
    /// v = Pi v
    void free_part(Span<Vec3> entries) const;
    /// f = Pi^T f
    void free_part_of_forces(Span<Vec3> entries) const;
    /// Gives the bodies their new velocities, without an entry in their ledgers.
    void take_over(Span<const Vec3> velocities, Solids& solids) const;

private:
    BodyVector vector_of(Span<const Vec3> entries) const;
    void write(const BodyVector& from, Span<Vec3> entries) const;

    BodyContacts contacts_;
    bool in_contact_ = false;
    double mass_ = 1;           ///< of a particle [kg]
    std::vector<Vec3> before_;  ///< velocities before the solve
};

}  // namespace whorl

#pragma once
/// The six rigid motions of a set of particles of equal mass, and of free bodies among them.
#include "engine/models/viscosity/viscous_bodies.h"

namespace whorl {

/// Removes the mean translation and rotation from a velocity field: what is left carries no momentum and no angular momentum.
class RigidMotions {
public:
    /// Removes nothing.
    RigidMotions() = default;
    /// @param turning false where the domain is periodic: there a rotation is no rigid motion
    /// @param bodies with two entries each behind the particles'; null: none
    RigidMotions(Span<const Vec3> x, bool turning, const ViscousBodies* bodies = nullptr);
    /// Of a velocity field.
    void remove(Span<Vec3> u) const;
    /// Of the forces (over m) that would make one: takes away what mass times a rigid motion is of them.
    void remove_force(Span<Vec3> f) const;

private:
    struct Motion;
    Motion sum(Span<const Vec3> u, bool masses) const;
    void take_off(Span<Vec3> u, const Motion& momenta, bool masses) const;

    Span<const Vec3> x_;
    const ViscousBodies* bodies_ = nullptr;
    double mass_ = 0;  ///< of all, over that of a particle
    Vec3d centre_ = Vec3d::Zero();
    Mat3d inverse_inertia_ = Mat3d::Zero();  ///< pseudo-inverse: a line of particles has no rotation about itself
};

}  // namespace whorl

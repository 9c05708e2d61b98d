#pragma once
/// The six rigid motions of a set of particles of equal mass.
#include "engine/core/types.h"

namespace whorl {

/// Removes the mean translation and rotation from a velocity field: what is left carries no momentum and no angular momentum.
class RigidMotions {
public:
    /// Removes nothing.
    RigidMotions() = default;
    /// @param turning false where the domain is periodic: there a rotation is no rigid motion
    RigidMotions(Span<const Vec3> x, bool turning);
    void remove(Span<Vec3> u) const;

private:
    Span<const Vec3> x_;
    Vec3d centre_ = Vec3d::Zero();
    Mat3d inverse_inertia_ = Mat3d::Zero();  ///< pseudo-inverse: a line of particles has no rotation about itself
};

}  // namespace whorl

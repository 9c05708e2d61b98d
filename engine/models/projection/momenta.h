#pragma once
/// Momentum and angular momentum of a single body in open space, which nothing pushes: a step of the projection leaves them as they are.
#include "engine/models/projection/projection_system.h"

namespace whorl {

/// Sums over equal particles: of u, and of x cross u.
struct Momenta {
    Vec3d momentum = Vec3d::Zero(), turning = Vec3d::Zero();
    void operator+=(const Momenta& o) { momentum += o.momentum, turning += o.turning; }
};

/// First stage of a step.
struct TakeMomenta {
    std::shared_ptr<Momenta> before;
    void operator()(Read<field::position> x, Read<field::velocity> u) const;
};

/// Last stage of a step. Corrected gradients are not pairwise opposite, and an implicit viscosity acts where the flow takes the particles:
/// of a body that turns at the rate w it takes (dt w)^2/2 of the angular momentum a step. What is missing is added as a rigid motion:
///   u += dP/n + (I^-1 dL) cross (x - centre),   I = sum (|r|^2 - r r^T) about the centre
struct KeepMomenta {
    std::shared_ptr<Momenta> before;
    bool turning = true;  ///< not of particles that spin, whose exchange with the flow is a torque
    void operator()(Read<field::position> x, Update<field::velocity> u) const;
};

}  // namespace whorl

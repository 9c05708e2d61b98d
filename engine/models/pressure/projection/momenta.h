#pragma once
/// Momentum and angular momentum of a single body in open space, which nothing pushes: a step of the projection leaves them as they are.
#include <memory>

#include "engine/models/viscosity/implicit_viscosity.h"

namespace whorl {

/// First stage of a step.
struct RecordMomentum {
    std::shared_ptr<Momenta> before;  ///< about the origin
    void operator()(Read<field::position> x, Read<field::velocity> u) const { *before = momenta_of(x.values, u.values, Vec3d::Zero()); }
};

/// Last stage of a step. Corrected gradients are not pairwise opposite, and an implicit viscosity acts where the flow takes the particles:
/// of a body that turns at the rate w it takes (dt w)^2/2 of the angular momentum a step. What is missing is added as a rigid motion:
///   u += dP/n + (I^-1 dL) cross (x - centre),   I = sum (|r|^2 - r r^T) about the centre
struct RestoreMomentum {
    std::shared_ptr<Momenta> before;
    bool turning = true;  ///< not of particles that spin, whose exchange with the flow is a torque
    void operator()(Read<field::position> x, Update<field::velocity> u) const {
        Momenta missing = -momenta_of(x.values, u.values, Vec3d::Zero());
        missing += *before;
        RigidMotions(x.values, turning).add(missing, u.values);
    }
};

}  // namespace whorl

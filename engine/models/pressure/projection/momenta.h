#pragma once
/// Conservation of momentum and angular momentum in a step of the projection, for a single body of fluid in open space on which no force
/// acts.
#include <memory>

#include "engine/models/viscosity/implicit_viscosity.h"

namespace whorl {

/// First stage of a step.
struct RecordMomentum {
    std::shared_ptr<Momenta> before;  ///< about the origin
    void operator()(Read<field::position> x, Read<field::velocity> u) const { *before = momenta_of(x.values, u.values, Vec3d::Zero()); }
};

/// Last stage of a step. It restores the momenta, for two reasons. The forces of corrected gradients are not pairwise opposite. An implicit
/// viscosity acts at the particles' new positions; by this alone, a body that rotates at the rate w would lose the fraction (dt w)^2/2 of
/// its angular momentum per step. The missing momentum dP and angular momentum dL, per mass of a particle, are added as a rigid motion of
/// the n particles:
///   u += dP/n + (I^-1 dL) cross (x - centre),   I = sum (|r|^2 - r r^T) about the centre
struct RestoreMomentum {
    std::shared_ptr<Momenta> before;
    bool turning = true;  ///< false if particles have spin, whose exchange with the flow is a torque
    void operator()(Read<field::position> x, Update<field::velocity> u) const {
        Momenta missing = -momenta_of(x.values, u.values, Vec3d::Zero());
        missing += *before;
        RigidMotions(x.values, turning).add(missing, u.values);
    }
};

}  // namespace whorl

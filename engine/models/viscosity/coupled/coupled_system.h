#pragma once
/// Viscosity and incompressibility in one symmetric positive definite solve per step, for fluids so viscous that they coil. The stages of
/// a step, in this order, share one CoupledSystem:
///
///   CoupledNeighbourhood   rows, contact gate, moments
///   CoupledGradient        gradient of the velocities before any force
///   CoupledSolve           the velocity at the end of the step, the multiplier (pressure), the gradient
///   CoupledMove            x += dt u
///   CoupledShift           separates close particles and adjusts their velocity: u += G dx
///   CoupledContact         stops particles at solids, where they stick or slide
///
/// Nozzles: prescribed particles (role -k) must fill at least `support` spacings above the opening.
#include <memory>

#include "engine/models/viscosity/coupled/contact_friction.h"
#include "engine/models/viscosity/coupled/two_level.h"
#include "engine/particles/field.h"

namespace whorl {

namespace field {
struct velocity_change {
    using type = Vec3;
    static constexpr std::string_view name = "velocity_change", unit = "m/s",
                                      meaning = "change over the last step, from which the next solve starts";
};
/// 0: none. k > 0: in aggregate k - 1 of the coarse level.
struct aggregate {
    using type = std::int32_t;
    static constexpr std::string_view name = "aggregate", unit = "",
                                      meaning = "rigid group that the particle belongs to in the coarse level";
};
/// 0: the particle is new. -1: no wall holds it. 1: a wall holds it, if any is near (CoupledOptions::wall_reach).
struct held {
    using type = std::int32_t;
    static constexpr std::string_view name = "held", unit = "", meaning = "whether a wall that the fluid sticks to has been touched";
};
/// Unit normal of the solid with slip (free, or with a slip length) that the particle touches, or zero.
struct contact_normal {
    using type = Vec3;
    static constexpr std::string_view name = "contact_normal", unit = "", meaning = "normal of the slippery solid that is touched";
};
}  // namespace field

/// Rigid rotation of the fluid in CoupledOptions::vessel.
struct VesselRotation {
    Vec3 centre = Vec3::Zero(), up = Vec3::Zero();  ///< point on the axis; unit vector along the axis
    Real rate = 0;                                  ///< angular velocity that follows from the fluid's angular momentum [rad/s]
    Vec3 arm(const Vec3& x) const { return up.cross(x - centre); }
    Vec3 acceleration(const Vec3& x) const { return rate * rate * up.cross(arm(x)); }
};

/// Data that the stages share within a step, and set-ups that are reused over several steps. All of these are rebuilt at a frame time.
struct CoupledSystem {
    explicit CoupledSystem(CoupledOptions chosen = {}) : options(chosen) {}
    CoupledOptions options;
    CoupledRows rows;
    StrainForm form;
    ContactFriction friction;
    TwoLevel preconditioner;
    VesselRotation rotation;  ///< in this step; none without CoupledOptions::vessel
    bool no_way_out = false;  ///< a solve since the last frame time found no pressure that keeps the volume of enclosed fluid
    /// Known pressures of surface tension [Pa], which add to the multiplier. Empty: there are none.
    std::shared_ptr<std::vector<Real>> known_pressure = std::make_shared<std::vector<Real>>();
};

}  // namespace whorl

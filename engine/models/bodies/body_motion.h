#pragma once
/// The stages of a free body's step, next to those of the particles (models/motion/motion.h): KickBodies after Kick, MoveBodies after Move.
#include "engine/geometry/body_contact.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// u += dt g, added to the explicit forces that the bodies have received; the layer has the new velocities.
struct KickBodies {
    void operator()(const InteractionContext& context) const;
};

/// x += dt u, and the turning by the angular momentum; poses follow with the next Solids::set_time(). Before that contacts, unless the
/// pressure's solve has held them (BodyRows).
struct MoveBodies {
    bool touch = true;
    void operator()(const InteractionContext& context) const;
};

ContactStep contact_step(const StepContext& step, double clearance = 0);

/// Least mass of a free body over that of the fluid that touches it (a particle of fluid for each of its layer's); 1 or more: 1. What acts
/// explicitly moves fluid and body in turn, so the lighter of the two bounds the step.
double lightness(const Solids& solids, const BoundaryParticles& boundary, Real mass);

}  // namespace whorl

#pragma once
/// Stages of a free body's step: KickBodies runs after Kick of the particles, MoveBodies after Move (models/motion/motion.h).
#include "engine/geometry/body_contact.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// u += dt g for each free body; the explicit forces have been added before. Then updates the velocities of the boundary particles.
struct KickBodies {
    void operator()(const InteractionContext& context) const;
};

/// x += dt u, and turns each body by its angular momentum. The poses follow with the next Solids::set_time(). If `touch`, resolves contacts
/// first. Set `touch` to false if the pressure's solve includes the contacts (BodyRows).
struct MoveBodies {
    bool touch = true;
    void operator()(const InteractionContext& context) const;
};

ContactStep contact_step(const StepContext& step, double clearance = 0);

/// Smallest ratio (mass of a free body)/(mass of the fluid that touches it), at most 1. The fluid's mass is that of one fluid particle for
/// each boundary particle of the body. Explicit forces move fluid and body in turn, so the lighter of the two limits the step.
double lightness(const Solids& solids, const BoundaryParticles& boundary, Real mass);

}  // namespace whorl

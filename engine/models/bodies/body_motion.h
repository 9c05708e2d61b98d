#pragma once
/// Stages of a free body's step: KickBodies runs after Kick of the particles, MoveBodies after Move (models/motion/motion.h).
#include "engine/geometry/body_contact.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// u += dt g for each free body, whose explicit forces have already been added. Then updates the velocities of the boundary particles.
struct KickBodies {
    void operator()(const InteractionContext& context) const;
};

/// x += dt u, and turns each body by its angular momentum. The poses follow with the next Solids::set_time(). Resolves contacts first
/// if `touch`; set it to false if the pressure's solve includes the contacts (BodyRows).
struct MoveBodies {
    bool touch = true;
    void operator()(const InteractionContext& context) const;
};

ContactStep contact_step(const StepContext& step, double clearance = 0);

/// Smallest ratio, over the free bodies, of a body's mass to the mass of the fluid that touches it (one fluid particle for each of the
/// body's boundary particles); at most 1. Explicit forces move fluid and body in turn, so the lighter of the two bounds the step.
double lightness(const Solids& solids, const BoundaryParticles& boundary, Real mass);

}  // namespace whorl

#pragma once
/// Free bodies touch each other and the other solids.
#include "engine/geometry/domain.h"
#include "engine/geometry/solids.h"

namespace whorl {

/// What contact needs to know of a time step.
struct ContactStep {
    double dt = 0;       ///< s
    double spacing = 0;  ///< m, between the particles of the layers
    Domain domain;
    double clearance = 0;  ///< m: bodies come no nearer than this to other solids; those that are nearer may stay
};

/// Changes the velocities of the free bodies so that none gets into another solid by the end of the step. At each place of contact
///   v_n >= -gap/dt        v_n: the normal part of the relative velocity there.
/// A place of contact is looked for from each particle of a body's layer near the other solid: down along the body's surface to where it
/// is deepest. Impulses there are equal and opposite, so momentum and angular momentum stay; Coulomb friction holds. They are found one
/// after the other in a fixed order, over and over (projected Gauss-Seidel). Overlaps are pushed apart by a fifth a step. A body bounces
/// where it comes faster than free fall over a spacing.
void resolve_contacts(Solids& solids, const SolidParticles& layer, const ContactStep& step, double gravity);

}  // namespace whorl

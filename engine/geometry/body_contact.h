#pragma once
/// Free bodies touch each other and the other solids.
#include "engine/geometry/domain.h"
#include "engine/geometry/solids.h"

namespace whorl {

/// What the step says about contact.
struct ContactStep {
    double dt = 0;       ///< s
    double spacing = 0;  ///< m, between the particles of the layers
    Domain domain;
};

/// Changes the velocities of the free bodies so that no place on the surface of one gets into another solid by the end of the step:
///   v_n >= -gap/dt        for each place looked at, v_n the normal part of the relative velocity there; from every particle of a body's
///   layer near the solid the
/// deepest place is looked for along the surface,
/// by impulses at that point, equal and opposite (momentum and angular momentum stay), with Coulomb friction: sequential impulses
/// (projected Gauss-Seidel) in a fixed order. Overlaps are pushed apart by a fifth a step; who comes faster than free fall over a spacing
/// bounces.
void resolve_contacts(Solids& solids, const SolidParticles& layer, const ContactStep& step, double gravity);

}  // namespace whorl

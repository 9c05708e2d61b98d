#pragma once
/// Free bodies touch each other and the other solids.
#include "engine/geometry/domain.h"
#include "engine/geometry/solids.h"

namespace whorl {

/// What the step says about contact.
struct TouchStep {
    double dt = 0;       ///< s
    double spacing = 0;  ///< m; a body touches with balls of half a spacing around the particles of its layer
    Domain domain;
};

/// Changes the velocities of the free bodies so that no ball of one gets deeper into another solid than its surface at the end of the step:
///   v_n >= -gap/dt        for each ball near a solid, v_n the normal part of the relative velocity where they would touch,
/// by impulses at that point, equal and opposite (momentum and angular momentum stay), with Coulomb friction: sequential impulses (projected
/// Gauss-Seidel) in a fixed order. Overlaps are pushed apart by a fifth a step; who comes faster than free fall over a spacing bounces.
void touch(Solids& solids, const SolidParticles& layer, const TouchStep& step, double gravity);

}  // namespace whorl

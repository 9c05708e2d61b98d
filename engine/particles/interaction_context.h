#pragma once
/// Neighbours, solids and parameters of a step, for the stages that need all of them.
#include "engine/geometry/solids.h"
#include "engine/particles/pairs.h"
#include "engine/particles/step_context.h"

namespace whorl {

struct InteractionContext {
    const FluidPairs& pairs;        ///< fluid neighbours of each fluid particle
    const SolidPairs& solid_pairs;  ///< boundary particles near each fluid particle
    Solids& solids;                 ///< free bodies among them receive forces and impulses
    BoundaryParticles& boundary;    ///< boundary particles of all solids, which follow the bodies
    const StepContext& step;
};

}  // namespace whorl

#pragma once
/// Neighbours, solids and parameters of a step, passed together to the stages that need all three.
#include "engine/geometry/solids.h"
#include "engine/particles/pairs.h"
#include "engine/particles/step_context.h"

namespace whorl {

struct InteractionContext {
    const FluidPairs& pairs;        ///< neighbours among the fluid
    const SolidPairs& solid_pairs;  ///< neighbours in the solids' layer
    Solids& solids;                 ///< free bodies among them take up forces and impulses
    BoundaryParticles& boundary;    ///< the one layer of particles of all solids; follows the bodies
    const StepContext& step;
};

}  // namespace whorl

#pragma once
/// Data shared by the stages of a run. A stage gets only the parts that its operator() names.
#include "engine/models/ink/ink_markers.h"
#include "engine/particles/interaction_context.h"
#include "engine/particles/search.h"

namespace whorl {

struct World {
    ParticleStore fluid;
    InkMarkers ink_markers;
    Solids solids;
    BoundaryParticles boundary_particles;
    FluidPairs fluid_pairs;
    SolidPairs solid_pairs;
    NeighbourSearch search;  ///< fills the pairs; reuses its memory in the next search
    StepContext step;
    StepReport report;

    InteractionContext context() { return {fluid_pairs, solid_pairs, solids, boundary_particles, step}; }
};

}  // namespace whorl

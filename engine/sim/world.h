#pragma once
/// Everything that the stages of a run share. A stage gets from here what its operator() names, nothing else.
#include "engine/geometry/solids.h"
#include "engine/particles/pairs.h"
#include "engine/particles/step_context.h"

namespace whorl {

struct World {
    ParticleStore fluid;
    Solids solids;
    SolidParticles solid_particles;
    FluidPairs fluid_pairs;
    SolidPairs solid_pairs;
    StepContext step;
    StepReport report;
};

}  // namespace whorl

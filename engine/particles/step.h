#pragma once
/// What a step knows (StepContext) and what it tells (StepReport).
#include <optional>
#include <string>
#include <vector>

#include "engine/geometry/domain.h"
#include "engine/math/kernel.h"
#include "engine/math/solve.h"

namespace whorl {

/// Constants of the fluid and of this step; the same for every particle.
struct StepContext {
    double time = 0;              ///< s, at the start of the step
    Real dt = 0;                  ///< s
    bool at_landing = true;       ///< the step starts at a frame time: refresh every lagged set-up, a resumed run starts here
    Vec3 gravity = Vec3::Zero();  ///< m/s^2
    Domain domain;

    Real spacing = 0;       ///< m, d
    Real support = 0;       ///< m, kernel radius R
    Real rest_density = 0;  ///< kg/m^3
    Real mass = 0;          ///< kg a particle: rest_density spacing^3
    Real volume = 0;        ///< m^3 a particle at rest: spacing^3
    KernelKind kernel = KernelKind::cubic;
};

/// Where and how a run went wrong: a result, not an exception.
struct Divergence {
    std::string stage, field;
    double time = 0;                 ///< s
    Vec3d place = Vec3d::Zero();     ///< m, of the first particle found
    std::string what;                ///< "velocity is not finite", ...
};

struct StepReport {
    struct Solve {
        std::string name;  ///< "pressure", "viscosity"
        SolveReport report;
    };
    std::vector<Solve> solves;
    Index lost_particles = 0;  ///< left the domain in this step
    std::optional<Divergence> diverged;
};

}  // namespace whorl

#pragma once
/// Fluid, solids and probes where they cannot be; more particles than memory.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

void check_placement(const Scene& scene, const Plan& plan, const SceneNumbers& numbers, const SceneShapes& shapes,
                     std::vector<Problem>& problems);

/// The part of a block, 0 to 1, that lies inside solids, or nearer to them than `margin` [m]: no particle is placed within .45 spacings.
double part_inside_solids(const SceneShapes& shapes, std::size_t block, double margin);
/// Share of the domain outside the solids where no block puts fluid at the start.
double part_left_empty(const Scene& scene, const SceneShapes& shapes);

}  // namespace whorl

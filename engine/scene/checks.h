#pragma once
/// What cannot work although every key is right by itself.
#include "engine/scene/numbers.h"
#include "engine/scene/plan.h"

namespace whorl {

/// Models that do not go together, or that this version does not have.
void check_models(const Scene& scene, const Plan& plan, const SceneNumbers& numbers, std::vector<Problem>& problems);

/// SceneNumbers::least_viscous_number from which on models.pressure = "coupled" works. It joins the particles by viscosity: thinner fluid
/// would have to part into drops, and its pools would lose height.
inline constexpr double coupled_works_from = 0.04;

/// Free bodies: what cannot be one, and models that do not move them.
void check_bodies(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

/// Fluid, solids and probes where they cannot be; more particles than memory.
void check_placement(const Scene& scene, const Plan& plan, const SceneNumbers& numbers, const SceneShapes& shapes,
                     std::vector<Problem>& problems);

/// The part of a block, 0 to 1, that lies inside solids: no particle is placed there. @param spacing [m]
double part_inside_solids(const SceneShapes& shapes, std::size_t block, double spacing);
/// Share of the domain outside the solids where no block puts fluid at the start.
double part_left_empty(const Scene& scene, const SceneShapes& shapes);
/// What pressure.form = "poisson" cannot hold: fluid that fills a periodic domain, and fluid between solids that face each other closely.
void check_poisson(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems);

}  // namespace whorl

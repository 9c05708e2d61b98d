#pragma once
/// Places the scene's fluid and solids in an empty world.
#include "engine/particles/drain.h"
#include "engine/particles/emitter.h"
#include "engine/scene/plan.h"
#include "engine/simulation/world.h"

namespace whorl {

/// Sets the step's constants from the plan.
void place_constants(const Scene& scene, const Plan& plan, World& world);
/// Places the solids at t = 0, with boundary particles if the plan's boundary model needs them.
void place_solids(const Scene& scene, const Plan& plan, World& world);
/// Places the fluid of the blocks outside solids and emitters' pipes. The columns of world.fluid must have been declared.
/// @throws InputError if a block contains no particle or a particle with invalid values, or if the domain is overfilled and the pressure
/// model does not move particles apart
void place_blocks(const Scene& scene, const Plan& plan, std::vector<Emitter>& emitters, World& world);
/// Initial positions of a block's particles.
std::vector<Vec3> points_of_block(const Scene& scene, const Plan& plan, const World& world, std::size_t b);
/// Assigns block particles in the pipe behind an opening to the emitter and fills the rest of the pipe, so that the pipe leaves no gap in
/// the fluid around it.
void fill_pipe(Emitter& emitter, const std::vector<std::shared_ptr<const Shape>>& shapes, const World& world,
               std::vector<std::vector<Vec3>>& points);
/// Sets viscosity and origin of the particles from index `first` on, which have just entered. Does nothing if no model needs it.
/// @param source 0: a block; k: emitter k - 1 @return a particle without a valid viscosity
std::optional<Divergence> set_viscosity(const Scene& scene, World& world, Index first, int source);
/// Sets the temperature of the particles from index `first` on, which have just entered, at a time [s]. Does nothing if the scene has none.
/// @param source as above @param block index of the block for source 0 @return a particle without a valid temperature
std::optional<Divergence> set_temperature(const Scene& scene, World& world, Index first, int source, std::size_t block, double time);
/// Sets inks and grains of the particles from index `first` on, which have just entered. Does nothing if the scene has none.
/// @param key name of the inks' key @return a particle whose ink is not a number
std::optional<Divergence> set_colours(const Scene& scene, World& world, Index first, const Inks& inks, const std::string& key, double time);
/// Sets the ids of the particles from index `first` on, which have just entered. Does nothing if no export or probe needs them.
/// @param next id of the next particle, updated
void set_ids(World& world, Index first, std::int32_t& next);
/// Applies a live change of fluid.viscosity: particles whose viscosity that key sets get the new value for their age and current position;
/// fluid of emitters with their own viscosity keeps it. @return a particle without a valid viscosity
std::optional<Divergence> change_viscosity(const Scene& scene, World& world);
/// A particle whose viscosity is not valid, as after change_viscosity(). Empty if the viscosity is not kept between steps.
std::optional<Divergence> wrong_viscosity(const World& world);
std::vector<Drain> make_drains(const Scene& scene);
/// Removes boundary particles of walls inside the nozzles that pass through the walls; the particles in the nozzles' pipes replace them.
void open_walls(const std::vector<Emitter>& emitters, World& world);
std::vector<Emitter> make_emitters(const Scene& scene, const Plan& plan, const Solids& solids);

}  // namespace whorl

#pragma once
/// Puts the scene's fluid and solids into an empty world.
#include "engine/particles/drain.h"
#include "engine/particles/emitter.h"
#include "engine/scene/plan.h"
#include "engine/simulation/world.h"

namespace whorl {

/// Fills the step's constants from the plan.
void place_constants(const Scene& scene, const Plan& plan, World& world);
/// Solids at t = 0, with their particles where the plan's boundary model wants any.
void place_solids(const Scene& scene, const Plan& plan, World& world);
/// Fluid of the blocks, outside of solids and of the emitters' pipes; columns must be declared. @throws InputError if a block holds no
/// particle, or one with values that are none, or where there are more than the room takes and the model does not move them apart
void place_blocks(const Scene& scene, const Plan& plan, std::vector<Emitter>& emitters, World& world);
/// Viscosity of the particles from `first` on, which have just come in, and where they came from; nothing if no model asks for it.
/// @param source 0: a block; k: emitter k - 1 @return a particle that has none
std::optional<Divergence> set_viscosity(const Scene& scene, World& world, Index first, int source);
/// Inks and grains of the particles from `first` on, which have just come in; nothing if the scene has none.
/// @param key of the inks @return a particle whose ink is not a number
std::optional<Divergence> set_colours(const Scene& scene, World& world, Index first, const Inks& inks, const std::string& key, double time);
/// Numbers of the particles from `first` on, which have just come in; nothing if no export asks for them.
/// @param next of the next particle; counts on
void set_ids(World& world, Index first, std::int32_t& next);
/// Applies a live change of fluid.viscosity: the particles whose viscosity that key gives get the new one, of their age and their
/// current place; those of emitters with their own viscosity keep it. @return a particle without a valid viscosity
std::optional<Divergence> change_viscosity(const Scene& scene, World& world);
/// A particle that such a change left without one, where the column lives on from step to step.
std::optional<Divergence> wrong_viscosity(const World& world);
std::vector<Drain> make_drains(const Scene& scene);
/// Removes a wall's particles where a nozzle goes through it: the pipe's particles replace them.
void open_walls(const std::vector<Emitter>& emitters, World& world);
std::vector<Emitter> make_emitters(const Scene& scene, const Plan& plan, const Solids& solids);

}  // namespace whorl

#pragma once
/// Key tables of the parts and lists of a scene, in the order of scene files.
#include "engine/core/keys.h"
#include "engine/scene/scene.h"

namespace whorl {

// Keys of the flow and its models.
KeyTable time_keys();
KeyTable domain_keys();
KeyTable fluid_keys();
KeyTable model_keys();
KeyTable pressure_keys();
KeyTable viscosity_keys();
KeyTable micropolar_keys();
KeyTable boundary_keys();
KeyTable heat_keys();

// Keys of what stands in the scene.
KeyTable block_keys();
KeyTable emitter_keys();
KeyTable solid_keys();
KeyTable light_keys();
KeyTable drain_keys();
KeyTable stream_keys();
KeyTable vortex_keys();
KeyTable probe_keys();

}  // namespace whorl

#pragma once
/// What is drawn of an emitter.
#include "engine/core/mesh.h"
#include "engine/particles/emitter.h"

namespace whorl {

/// A tube around an emitter's opening: the wall stands half a spacing outside the fluid, the tube reaches `length` [m] back from the
/// opening.
TriangleMesh nozzle_mesh(const EmitterShape& opening, Real spacing, Real length);

}  // namespace whorl

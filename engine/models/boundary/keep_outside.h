#pragma once
/// The last resort against penetration, after the move.
#include "engine/particles/field.h"
#include "engine/particles/surroundings.h"

namespace whorl {

/// A free particle that stands inside a solid is put back on its surface and loses the part of its velocity (relative to the solid) that
/// points into the solid. One that a step brought through a solid, or nearer to its far side, is put back where it met it: so plates of any
/// thickness hold. A free body gets the impulse that the particle loses; the two then part as they meet, with
/// their common mass.
struct KeepOutside {
    void operator()(const Surroundings& around, Read<field::role> role, Update<field::position> x, Update<field::velocity> u) const;
};

}  // namespace whorl

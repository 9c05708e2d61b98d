#pragma once
#include <memory>
#include <utility>

#include "engine/geometry/shape.h"
#include "engine/geometry/solids.h"

namespace whorl::test {

/// A solid of this shape, or a free body if it has a density [kg/m^3].
inline Solid solid_of(std::shared_ptr<const Shape> shape, double density = 0) {
    Solid solid;
    solid.shape = std::move(shape);
    if (density > 0) solid.body = RigidBody(solid.shape->bulk(), density);
    return solid;
}

/// One solid of this shape, at time 0.
inline Solids solids_of(std::shared_ptr<const Shape> shape) {
    Solids solids;
    solids.all.push_back(solid_of(std::move(shape)));
    solids.set_time(0, 1e-3);
    return solids;
}

}  // namespace whorl::test

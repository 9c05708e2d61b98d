#pragma once
/// The shapes of a scene, and their bounds.
#include <memory>
#include <vector>

#include "engine/geometry/solids.h"
#include "engine/particles/emitter.h"
#include "engine/scene/scene.h"

namespace whorl {

/// Bounds [m] and volume [m^3] of a shape. A plane has infinite bounds and volume 0.
struct Extent {
    Vec3d min = Vec3d::Zero(), max = Vec3d::Zero();
    double volume = 0;
};

/// The shapes of a scene. Solids are at their initial positions.
struct SceneShapes {
    std::vector<std::shared_ptr<const Shape>> blocks, drains;
    Solids solids;
    std::vector<Extent> block_extent, solid_extent, drain_extent;
};
/// The shape of a solid, with the thickness of a vessel's wall (by default 3 spacings).
ShapeKeys shape_of(const Scene& scene, const SolidKeys& keys);
/// Slip length [m]: 0 if the fluid sticks, infinite if it slides freely.
double slip_length_of(const SolidKeys& keys);
/// The solid of this shape according to the scene. It has no pose before Solids::set_time(). The shape of a free body must be bounded.
Solid solid_of(const SolidKeys& keys, std::shared_ptr<const Shape> shape);
/// The opening according to the scene.
/// The opening at t = 0.
EmitterShape opening_of(const EmitterKeys& keys, int dimensions);
/// Appends unusable meshes to `problems`. The shapes are complete only if none was added.
SceneShapes make_shapes(const Scene& scene, std::vector<Problem>& problems);
/// Whether x is inside a solid or nearer to one than `margin` [m]. No particle of a block is placed within least_clearance spacings.
bool in_solids(const SceneShapes& shapes, const Vec3& x, double margin);

}  // namespace whorl

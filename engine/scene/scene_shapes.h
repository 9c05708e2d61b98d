#pragma once
/// The shapes of a scene, with their bounds.
#include <memory>
#include <vector>

#include "engine/geometry/solids.h"
#include "engine/particles/emitter.h"
#include "engine/scene/scene.h"

namespace whorl {

/// Bounds [m] and volume [m^3] of a shape; a plane has infinite bounds and no volume.
struct Extent {
    Vec3d min = Vec3d::Zero(), max = Vec3d::Zero();
    double volume = 0;
};

/// The shapes of a scene as geometry; solids are at their start positions.
struct SceneShapes {
    std::vector<std::shared_ptr<const Shape>> blocks, drains;
    Solids solids;
    std::vector<Extent> block_extent, solid_extent, drain_extent;
};
/// 0 where the fluid sticks, infinite if it slides freely [m].
double slip_length_of(const SolidKeys& keys);
/// The solid of this shape as the scene describes it; it has no pose before Solids::set_time(). A free one's shape must be bounded.
Solid solid_of(const SolidKeys& keys, std::shared_ptr<const Shape> shape);
/// The opening as the scene describes it.
EmitterShape opening_of(const EmitterKeys& keys, int dimensions);
/// Appends to `problems` where a mesh cannot be used; the shapes are complete only where it added none.
SceneShapes make_shapes(const Scene& scene, std::vector<Problem>& problems);
/// Is x inside a solid, or nearer to one than `margin` [m]? No particle of a block is placed within least_clearance spacings.
bool in_solids(const SceneShapes& shapes, const Vec3& x, double margin);

}  // namespace whorl

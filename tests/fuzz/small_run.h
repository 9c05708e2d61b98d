#pragma once
/// Runs so small that thousands of them take a minute.
#include "engine/io/snapshot.h"
#include "engine/probes/probes.h"
#include "engine/scene/scene_scales.h"
#include "render/surface/surface.h"
#include "tests/fuzz/target.h"

namespace whorl::fuzz {

constexpr double few = 500;  // particles

/// Whether the scene begins with few particles, including those in nozzles and on solids.
inline bool is_small(const Scene& scene, const Plan& plan) {
    std::vector<Problem> none;
    const SceneShapes shapes = make_shapes(scene, none);
    double count = 0;
    for (const Extent& block : shapes.block_extent) count += block.volume / plan.particle_volume();
    for (const EmitterKeys& emitter : scene.emitters) count += nozzle_points(emitter, plan.spacing, plan.dimensions());
    for (std::size_t k = 0; k < scene.solids.size(); ++k) count += layer_points(scene, shapes, k, plan.support);
    return count < few;
}

/// A step towards the second frame. Afterwards every probe reports its values.
inline void step_once(Simulation& simulation, const NamedProbes& probes) {
    if (simulation.step(frame_time(simulation.scene(), 2)).diverged) return;
    for (const auto& [name, probe] : probes) {
        probe->after_step(simulation.world(), simulation.time());
        for (const auto& row : rows_of(*probe, simulation)) expect(row.size() == probe->columns().size(), "a row has every column");
    }
}

/// The surface of few particles, with the distance volume if that is also small.
inline void surface_of(const Frame& frame, SurfaceOptions options) {
    if (static_cast<double>(frame.position.size()) > few) return;
    Vec3f low = Vec3f::Zero(), high = low;
    for (const Vec3f& x : frame.position) low = low.cwiseMin(x), high = high.cwiseMax(x);
    options.voxel = std::max(options.voxel, 0.4);
    options.distance = options.distance && ((high - low) / frame.spacing).prod() < 1e3f;
    const Surface surface = build_surface(frame, options);
    for (const auto& triangle : surface.mesh.triangle)
        for (const auto corner : triangle) expect(corner < surface.mesh.position.size(), "corners are vertices");
}

}  // namespace whorl::fuzz

#include "render/surface/surface.h"

#include <cmath>

#include "engine/core/errors.h"
#include "render/surface/distance.h"
#include "render/surface/march.h"
#include "render/surface/smooth.h"
#include "render/surface/vertex_values.h"

namespace whorl {

Surface build_surface(const Frame& frame, const SurfaceOptions& options) {
    if (frame.position.empty()) return {};
    WHORL_ASSERT(frame.spacing > 0 && options.voxel > 0 && options.radius > options.voxel);
    const auto voxel = static_cast<float>(options.voxel * frame.spacing), iso = static_cast<float>(options.iso);
    const Cut cut = cut_of(frame);
    // Wide enough that the field is whole up to the cut and a block of nodes beyond it.
    const Ghosted ghosted = with_ghosts(frame, static_cast<float>(2 * options.radius * frame.spacing));
    const ColourField field(cut.any() ? ghosted.position : frame.position, frame.spacing, options.radius);
    const ColourGrid grid(field, voxel, cut, iso);
    MarchedMesh marched = march(grid, iso);
    project(field, iso, voxel, grid, cut, marched);
    Surface surface;
    surface.mesh = std::move(marched.mesh);
    if (options.smoothing > 0) {
        const std::vector<Vec3f> sharp = cut.any() ? surface.mesh.position : std::vector<Vec3f>();
        const int steps = static_cast<int>(std::lround(2.5 / (options.voxel * options.voxel)));
        smooth(surface.mesh, options.smoothing, steps);
        // The cut stays plane and its rim in place: both sides of a period fit together.
        for (std::size_t v = 0; v < sharp.size(); ++v)
            if (std::abs(cut.at(sharp[v]).inside) < 0.02f * voxel) surface.mesh.position[v] = sharp[v];
        set_smooth_normals(surface.mesh, options.smoothing * steps);
    }
    if (const auto age = frame.scalar.find("age"); options.ages && age != frame.scalar.end()) {
        surface.age = values_at(surface.mesh.position, frame.position, age->second, static_cast<float>(options.radius * frame.spacing));
        if (const auto grain = frame.scalar.find("grain"); grain != frame.scalar.end())
            surface.crust = crust_places(surface.mesh.position, frame.position, grain->second, frame.spacing);
    }
    if (options.velocity)
        surface.velocity =
            values_at(surface.mesh.position, frame.position, frame.velocity, static_cast<float>(options.radius * frame.spacing));
    if (options.distance) surface.distance = distance_volume(surface.mesh, voxel, 8);
    return surface;
}

}  // namespace whorl

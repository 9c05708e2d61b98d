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
    const Cut cut(frame);
    // Wide enough that the field is whole up to the cut and a block of nodes beyond it.
    const auto margin = static_cast<float>(2 * options.radius * frame.spacing);
    Ghosted ghosted = with_ghosts(frame, margin);
    std::vector<Vec3f>& all = ghosted.position;
    if (cut.any()) {
        if (all.empty()) all = frame.position;
        const std::vector<Vec3f> images = cut.images(all, margin);
        all.insert(all.end(), images.begin(), images.end());
    }
    const ColourField field(cut.any() ? all : frame.position, frame.spacing, options.radius);
    const ColourGrid grid(field, voxel, cut, iso);
    MarchedMesh marched = march(grid, iso);
    project(field, iso, voxel, grid, cut, marched);
    Surface surface;
    surface.mesh = std::move(marched.mesh);
    if (options.smoothing > 0) {
        const std::vector<Vec3f> sharp = cut.any() ? surface.mesh.position : std::vector<Vec3f>();
        const int steps = static_cast<int>(std::lround(2.5 / (options.voxel * options.voxel)));
        smooth(surface.mesh, options.smoothing, steps);
        for (std::size_t v = 0; v < sharp.size(); ++v)
            surface.mesh.position[v] = cut.held(sharp[v], surface.mesh.position[v], 0.02f * voxel);
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

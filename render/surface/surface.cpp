#include "render/surface/surface.h"

#include <cmath>

#include "engine/core/errors.h"
#include "render/surface/distance.h"
#include "render/surface/march.h"
#include "render/surface/smooth.h"

namespace whorl {

Surface build_surface(const Frame& frame, const SurfaceOptions& options) {
    if (frame.position.empty()) return {};
    WHORL_ASSERT(frame.spacing > 0 && options.voxel > 0 && options.radius > options.voxel);
    const ColourField field(frame.position, frame.spacing, options.radius);
    const auto voxel = static_cast<float>(options.voxel * frame.spacing), iso = static_cast<float>(options.iso);
    const ColourGrid grid(field, voxel);
    MarchedMesh marched = march(grid, iso);
    project(field, iso, voxel, grid, marched);
    Surface surface;
    surface.mesh = std::move(marched.mesh);
    if (options.smoothing > 0) {
        smooth(surface.mesh, options.smoothing, static_cast<int>(std::lround(2.5 / (options.voxel * options.voxel))));
        set_normals(surface.mesh);
    }
    if (options.distance) surface.distance = distance_volume(surface.mesh, voxel, 8);
    return surface;
}

}  // namespace whorl

#include <fmt/format.h>

#include <algorithm>

#include "engine/scene/checks.h"
#include "engine/scene/scene_scales.h"

namespace whorl {

std::vector<std::string> warnings_of_lids(const Scene& scene, const SceneShapes& shapes) {
    std::vector<std::string> found;
    const std::vector<double> times = sample_times(0, scene.time.end);
    const auto is_bounded = [&](std::size_t k) { return shapes.solids.all[k].shape->bounded(); };
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {
        if (!scene.solids[k].closed() || !is_bounded(k)) continue;
        for (std::size_t j = 0; j < scene.solids.size(); ++j) {
            const SolidKeys& solid = scene.solids[j];
            if (solid.container || !solid.position.depends_on_time() || !is_bounded(j)) continue;
            const Extent& e = shapes.solid_extent[j];
            bool through = false;
            for (int corner = 0; corner < 8 && !through; ++corner) {
                const Vec3d at(corner & 1 ? e.min.x() : e.max.x(), corner & 2 ? e.min.y() : e.max.y(), corner & 4 ? e.min.z() : e.max.z());
                double shallowest = 0, deepest = 0;  // depth below the container's surface [m]; negative outside
                for (const double t : times) {
                    const Vec3d x = at + solid.position(t) - scene.solids[k].position(t);
                    const double depth = -static_cast<double>(shapes.solids.all[k].shape->distance(x.cast<Real>()));
                    shallowest = std::min(shallowest, depth), deepest = std::max(deepest, depth);
                }
                through = shallowest < -scene.fluid.spacing && deepest > scene.fluid.spacing;
            }
            if (through)
                found.push_back(
                    fmt::format("solid[{}] moves through the wall or the lid of solid[{}] (container = true), which is closed on all "
                                "sides; open it (open = \"top\"), or make it larger than the solid's path",
                                j, k));
        }
    }
    return found;
}

}  // namespace whorl

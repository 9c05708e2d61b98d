#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/checks.h"
#include "engine/scene/numbers.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

class LidWarnings {
public:
    LidWarnings(const Scene& scene, const SceneShapes& shapes) : scene_(scene), shapes_(shapes), d_(scene.fluid.spacing) {}
    std::vector<std::string> all() {
        for (std::size_t k = 0; k < scene_.solids.size(); ++k)
            if (scene_.solids[k].container && shapes_.solids.all[k].shape->bounded()) warn_of_lid(k);
        return std::move(all_);
    }

private:
    /// Depth of a place below the surface of container k [m]; negative outside.
    double depth_in(std::size_t k, const Vec3d& x, double t) const {
        return -static_cast<double>(shapes_.solids.all[k].shape->distance((x - scene_.solids[k].position(t)).cast<Real>()));
    }

    /// A container is closed all round: solids that move through its wall, and fluid that flies against its upper side.
    void warn_of_lid(std::size_t k) {
        const std::vector<double> times = sample_times(0, scene_.time.end);
        const auto warn = [&](const std::string& what, const char* reach) {
            all_.push_back(
                fmt::format("{} of solid[{}] (container = true), which is closed all round; make it as high as {}", what, k, reach));
        };
        for (std::size_t j = 0; j < scene_.solids.size(); ++j) {
            const SolidKeys& solid = scene_.solids[j];
            if (j == k || solid.container || !solid.position.depends_on_time() || !shapes_.solids.all[j].shape->bounded()) continue;
            const Extent& e = shapes_.solid_extent[j];
            bool through = false;
            for (int corner = 0; corner < 8 && !through; ++corner) {
                const Vec3d at(corner & 1 ? e.min.x() : e.max.x(), corner & 2 ? e.min.y() : e.max.y(), corner & 4 ? e.min.z() : e.max.z());
                const auto [least, most] = std::minmax_element(times.begin(), times.end(), [&](double s, double t) {
                    return depth_in(k, at + solid.position(s), s) < depth_in(k, at + solid.position(t), t);
                });
                through = depth_in(k, at + solid.position(*least), *least) < -d_ && depth_in(k, at + solid.position(*most), *most) > d_;
            }
            if (through) warn(fmt::format("solid[{}] moves through the wall or the lid", j), "it reaches");
        }
        const auto rises = [&](const std::string& name, const Vec3d& x, const Vec3d& u, double t) {
            const Vec3d g = scene_.domain.gravity(t);
            if (!(u.dot(g) < 0) || depth_in(k, x, t) < 0) return;
            const double height = std::pow(u.dot(g), 2) / (2 * std::pow(g.norm(), 3));
            if (depth_in(k, x - height * g.normalized(), t) < 0)
                warn(fmt::format("{} rises by {:.3g} m, against the lid", name, height), "it rises");
        };
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i) {
            const EmitterKeys& e = scene_.emitters[i];
            rises(entry_name("emitter", i), e.position, fastest_of(e, scene_.time.end) * e.direction, std::max(0.0, e.start));
        }
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i) {
            const Vec3d middle = 0.5 * (shapes_.block_extent[i].min + shapes_.block_extent[i].max);
            rises(entry_name("block", i), middle, scene_.blocks[i].velocity(0, middle), 0);
        }
    }

    const Scene& scene_;
    const SceneShapes& shapes_;
    double d_;
    std::vector<std::string> all_;
};

}  // namespace

std::vector<std::string> warnings_of_lids(const Scene& scene, const SceneShapes& shapes) { return LidWarnings(scene, shapes).all(); }

}  // namespace whorl

#include "engine/scene/check_poisson.h"

#include <fmt/format.h>

#include <limits>

#include "engine/scene/check_placement.h"
#include "engine/scene/key_problems.h"

namespace whorl {
namespace {

/// Slots 2, 3, 4 and 6 d wide explode within 0.2 s, 10 d between floor and ceiling hold.
constexpr double narrowest_slot = 8;  ///< d

/// How far it is from one solid straight to the next one that faces it, at a sample of the places where fluid starts [m]; infinite beyond
/// `most`.
double narrowest_gap(const SceneShapes& shapes, double spacing, double most) {
    constexpr int points = 17;  // an axis of a block
    double narrowest = std::numeric_limits<double>::infinity();
    for (std::size_t block = 0; block < shapes.blocks.size(); ++block) {
        const Extent& e = shapes.block_extent[block];
        for (int i = 0; i < points * points * points; ++i) {
            const Vec3d part = (Vec3d(i % points, i / points % points, i / (points * points)) + Vec3d::Constant(0.5)) / points;
            const Vec3 x = (e.min + part.cwiseProduct(e.max - e.min)).cast<Real>();
            if (shapes.blocks[block]->distance(x) > 0) continue;
            Real height = 0;
            const int k = shapes.solids.nearest(x, height);
            if (k < 0 || height < 0 || static_cast<double>(height) > most / 2) continue;
            const Vec3 away = shapes.solids.all[k].normal(x);
            for (double t = spacing / 4; static_cast<double>(height) + t < std::min(most, narrowest); t += spacing / 4) {
                Real distance = 0;
                const Vec3 there = x + static_cast<Real>(t) * away;
                const int hit = shapes.solids.nearest(there, distance);
                // Facing each other, not a corner of a wall and the floor.
                if (hit >= 0 && distance < 0 && shapes.solids.all[hit].normal(there).dot(away) < Real(-0.7))
                    narrowest = static_cast<double>(height) + t;
            }
        }
    }
    return narrowest;
}

}  // namespace

void check_poisson(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems) {
    if (plan.facts.pressure.form != PressureForm::poisson) return;
    const auto report = [&](const std::string& what) {
        KeyProblems(scene, problems)("pressure.form", what, "take pressure.form = \"constraint\", which needs no special case there");
    };
    if (scene.domain.box().all_periodic() && part_left_empty(scene, shapes) < 0.02)
        report(
            "pressure.form = \"poisson\" diverges in fluid that fills a periodic domain: its force is not the transpose of its divergence, "
            "and nothing takes away what it adds");
    if (const double gap = narrowest_gap(shapes, plan.spacing, narrowest_slot * plan.spacing); gap < narrowest_slot * plan.spacing)
        report(fmt::format(
            "pressure.form = \"poisson\" diverges between solids that face each other closely, and these stand {:.2g} spacings apart",
            gap / plan.spacing));
}

}  // namespace whorl

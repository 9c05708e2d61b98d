#include "engine/scene/check_projection.h"

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

void check_density_source(const Scene& scene, const Plan& plan, const SceneShapes& shapes, const KeyProblems& problem) {
    const auto report = [&](const std::string& what) {
        problem("pressure.source", what, "take pressure.source = \"velocity\", which needs no special case there");
    };
    if (scene.domain.box().all_periodic() && part_left_empty(scene, shapes) < 0.02)
        report(
            "pressure.source = \"density\" diverges in fluid that fills a periodic domain: its force is not the transpose of its "
            "divergence, and nothing takes away what it adds");
    if (const double gap = narrowest_gap(shapes, plan.spacing, narrowest_slot * plan.spacing); gap < narrowest_slot * plan.spacing)
        report(fmt::format(
            "pressure.source = \"density\" diverges between solids that face each other closely, and these stand {:.2g} spacings apart",
            gap / plan.spacing));
}

/// Share of the fluid's sides and bottom that nothing holds, so that it will fall or flow out. Looked at on a lattice of places in each
/// block that are nearer than a spacing to its boundary.
double part_unsupported(const Scene& scene, const SceneShapes& shapes, double spacing) {
    constexpr int points = 33;  // an axis of a block
    const Vec3d up = -scene.domain.gravity(0).normalized();
    int sides = 0, open = 0;
    for (std::size_t block = 0; block < shapes.blocks.size(); ++block) {
        const Extent& e = shapes.block_extent[block];
        const bool plane = scene.domain.dimensions == 2;
        for (int i = 0; i < points * points * (plane ? 1 : points); ++i) {
            const Vec3d part = (Vec3d(i % points, i / points % points, i / (points * points)) + Vec3d::Constant(0.5)) / points;
            Vec3 x = (e.min + part.cwiseProduct(e.max - e.min)).cast<Real>();
            if (plane) x[2] = 0;
            const Real depth = shapes.blocks[block]->distance(x);
            // Within a share of the block that the lattice is fine enough for.
            const Vec3d extent = e.max - e.min;
            const auto near = static_cast<Real>(std::max(spacing, 2 * extent.maxCoeff() / points));
            if (depth >= 0 || depth < -near) continue;
            const Vec3 out = shapes.blocks[block]->normal(x);
            if (out.cast<double>().dot(up) > 0.5) continue;
            const Vec3 beyond = x + (static_cast<Real>(spacing) - depth) * out;
            ++sides;
            bool held = false;
            for (int a = 0; a < 3; ++a)  // a periodic side is held by the fluid's own image
                held = held || (scene.domain.periodic[a] &&
                                (beyond[a] < static_cast<Real>(scene.domain.min[a]) || beyond[a] > static_cast<Real>(scene.domain.max[a])));
            for (const auto& other : shapes.blocks) held = held || other->distance(beyond) < 0;
            Real distance = 0;
            held = held || (shapes.solids.nearest(beyond, distance) >= 0 && distance < static_cast<Real>(spacing));
            open += !held;
        }
    }
    return sides > 0 ? static_cast<double>(open) / sides : 0;
}

void check_splashing(const Scene& scene, const Plan& plan, const SceneShapes& shapes, const KeyProblems& problem) {
    if (plan.facts.viscosity.smooths)
        problem("models.viscosity", "a full box diverges with XSPH under pressure.form = \"projection\"",
                "take models.viscosity = \"explicit\", or pressure.form = \"constraint\"");
    if (!plan.free_surface) return;
    const auto report = [&](const std::string& what) {
        problem("pressure.form", "pressure.form = \"projection\" does not hold fluid that splashes, and " + what,
                "take pressure.form = \"constraint\", or \"auto\", which does so");
    };
    if (!scene.emitters.empty()) report("emitters pour");
    else if (scene.domain.gravity(0).norm() == 0) report("without weight nothing keeps its surface together");
    else if (const double open = part_unsupported(scene, shapes, plan.spacing); open > 0.03)
        report(fmt::format("nothing holds {:.0f} % of this fluid's sides: it will fall or flow out", 100 * open));
}

}  // namespace

void check_projection(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems) {
    const KeyProblems problem(scene, problems);
    if (plan.facts.pressure.source == PressureSource::density) check_density_source(scene, plan, shapes, problem);
    if (plan.facts.pressure.source == PressureSource::velocity) check_splashing(scene, plan, shapes, problem);
}

}  // namespace whorl

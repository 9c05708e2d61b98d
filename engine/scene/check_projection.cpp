#include <algorithm>

#include "engine/scene/checks.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// Whether fluid is behind the pipe of a nozzle: the projection lets it flow into the pipe.
bool pipe_in_fluid(const SceneShapes& shapes, const EmitterKeys& e, const Plan& plan) {
    const Vec3 behind = (e.position - (plan.support + 2 * plan.spacing) * e.direction.normalized()).cast<Real>();
    return !in_solids(shapes, behind, 0) &&
           std::any_of(shapes.blocks.begin(), shapes.blocks.end(), [&](const auto& b) { return b->distance(behind) < 0; });
}

void check_velocity_source(const Scene& scene, const Plan& plan, const SceneShapes& shapes, const KeyProblems& problem) {
    if (plan.facts.viscosity.smooths)
        problem("models.viscosity",
                "pressure.form = \"projection\" does not run with XSPH: a full box diverges, open tanks were not measured",
                "use models.viscosity = \"explicit\", or pressure.form = \"constraint\"");
    if (!plan.free_surface) return;
    for (std::size_t k = 0; k < scene.solids.size(); ++k)
        if (scene.fluid.surface_tension > 0 && scene.solids[k].wetting != 0.5)
            problem(entry_name("solid", k) + ".wetting",
                    "with pressure.form = \"projection\" a surface meets solids at 90 degrees, wetting = 0.5",
                    "use 0.5, or pressure.form = \"constraint\"", "allowed: 0.5");
    for (std::size_t k = 0; k < scene.emitters.size(); ++k)
        if (pipe_in_fluid(shapes, scene.emitters[k], plan))
            problem("pressure.form",
                    "pressure.form = \"projection\" lets fluid flow from behind into the pipe of " + entry_name("emitter", k) +
                        ", which is in the fluid",
                    "use pressure.form = \"constraint\", or \"auto\", which does so");
    for (std::size_t k = 0; k < scene.solids.size(); ++k)
        if (scene.domain.dimensions == 3 && !scene.solids[k].container && scene.solids[k].shape.kind != "plane")
            problem("pressure.form",
                    "in 3D with a free surface, pressure.form = \"projection\" diverges next to a solid in the fluid, such as " +
                        entry_name("solid", k),
                    "use pressure.form = \"constraint\", or \"auto\", which does so");
}

}  // namespace

void check_projection(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems) {
    const KeyProblems problem(scene, problems);
    if (plan.facts.pressure.source == PressureSource::velocity) check_velocity_source(scene, plan, shapes, problem);
    const bool weightless = scene.domain.box().all_periodic() || scene.domain.gravity(0).norm() == 0;
    if (plan.facts.pressure.source == PressureSource::density && !plan.free_surface && weightless)
        problem("pressure.source",
                "pressure.source = \"density\" gains energy in fluid that fills its space and rests on nothing: only weight damps what its "
                "density errors shake",
                "use pressure.source = \"velocity\"");
}

}  // namespace whorl

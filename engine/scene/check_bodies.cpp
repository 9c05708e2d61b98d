#include "engine/scene/check_bodies.h"

#include "engine/scene/key_problems.h"
#include "engine/scene/tree.h"

namespace whorl {

void check_bodies(const Scene& scene, const Plan& plan, std::vector<Problem>& problems) {
    const KeyProblems report(scene, problems);
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {
        const SolidKeys& solid = scene.solids[k];
        const std::string name = entry_name("solid", k);
        if (solid.density == 0) {
            if (solid.velocity != Vec3d::Zero())
                report(name + ".velocity", name + ".velocity is for free bodies, and " + name + " has no density",
                       "give it a density; or let it move by position and rotation, expressions of t");
            continue;
        }
        if (solid.shape.kind == "plane")
            report(name + ".density", name + " is a plane, which has no end: it cannot be a free body", "take a box");
        if (solid.inside)
            report(name + ".density", name + " is a container of the fluid (inside): it cannot be a free body",
                   "make a hollow body from a mesh");
        if (solid.slip == Slip::navier)
            report(name + ".slip", "along free bodies the fluid sticks or slides freely: a slip length does not push back on them",
                   "take \"no\" or \"free\"");
        if (solid.position.depends_on_time() || solid.rotation.depends_on_time())
            report(name + ".density", name + " has a density, so forces move it, and position or rotation, which depend on t, cannot",
                   "give where it starts, and its velocity");
    }
    if (!scene.any_free_solid()) return;
    if (!plan.facts.pressure.moves_bodies)
        report("models.pressure",
               "models.pressure = " + described(plan.facts.pressure) + " does not move free bodies (solids with a density)",
               "take " + described(pressure_models(), &PressureFacts::moves_bodies));
    else if (plan.boundary == BoundaryModel::none)
        report("models.boundary", "free bodies feel the fluid through their layer of particles, and models.boundary is none",
               "take \"auto\"");
    if (!plan.facts.viscosity.moves_bodies)
        report("models.viscosity", "models.viscosity = " + described(plan.facts.viscosity) + " does not move free bodies",
               "take " + described(viscosity_models(), &ViscosityFacts::moves_bodies));
    if (scene.fluid.surface_tension > 0) report("fluid.surface_tension", "surface tension does not pull on free bodies", "take 0");
    if (plan.facts.micropolar.spins) report("models.micropolar", "micropolar fluids do not move free bodies", "take \"none\"");
}

}  // namespace whorl

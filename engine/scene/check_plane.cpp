#include "engine/scene/check_plane.h"

#include "engine/scene/key_problems.h"
#include "engine/scene/tree.h"

namespace whorl {

void check_plane(const Scene& scene, const Plan& plan, std::vector<Problem>& problems) {
    if (scene.domain.dimensions == 3) return;
    const KeyProblems report(scene, problems);
    const std::string here = " in two dimensions (domain.dimensions = 2)";
    if (scene.fluid.surface_tension > 0 && plan.facts.pressure.source != PressureSource::velocity)
        report("fluid.surface_tension", "particles that pull at each other make no surface tension" + here,
               "take 0, or pressure.form = \"projection\"", "allowed: 0");
    if (!scene.vortices.empty())
        report(entry_name("vortex", 0), "a closed vortex line needs space: there is none" + here,
               "give the velocity of [[block]] as expressions");
    for (std::size_t k = 0; k < scene.probes.size(); ++k)
        if (scene.probes[k].kind == ProbeKind::coil)
            report(entry_name("probe", k) + ".kind", "nothing coils" + here, "", "allowed: every other kind");
    for (const std::string what : {"mesh", "obj", "vdb"})
        if (scene.exported(what))
            report("output.export", "there is no surface to export as \"" + what + "\"" + here, "", "allowed: points, vtk, scene or raw");
}

}  // namespace whorl

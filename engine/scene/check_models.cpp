#include "engine/scene/checks.h"
#include "engine/scene/names.h"

namespace whorl {

void check_models(const Scene& scene, const Plan& plan, std::vector<Problem>& problems) {
    const auto report = [&](const std::string& key, const std::string& what, const std::string& hint, const std::string& allowed = "") {
        problems.push_back({scene.place(key), what, hint, allowed.empty() ? "" : "allowed: " + allowed});
    };
    const std::string not_here = " is not available in this version";

    if (plan.micropolar != MicropolarModel::none)
        report("models.micropolar", std::string("models.micropolar = \"") + name_of(plan.micropolar) + "\"" + not_here, "", "none");
    if (plan.viscosity == ViscosityModel::pairwise || plan.viscosity == ViscosityModel::full_assembled)
        report("models.viscosity", std::string("models.viscosity = \"") + name_of(plan.viscosity) + "\"" + not_here, "take \"full\"",
               "auto, none, xsph, explicit or full");
    if (plan.pressure == PressureModel::ppe && scene.pressure.preconditioner == Preconditioner::multigrid)
        report("pressure.preconditioner", "pressure.preconditioner = \"multigrid\"" + not_here, "take \"jacobi\"", "none or jacobi");
    if (scene.fluid.surface_tension > 0) report("fluid.surface_tension", "surface tension" + not_here, "set fluid.surface_tension = 0");
    if (scene.boundary.gate > 0) report("boundary.gate", "the gate at solids" + not_here, "set boundary.gate = 0");

    if (plan.pressure == PressureModel::coupled && plan.viscosity != ViscosityModel::none)
        report("models.viscosity", "models.pressure = \"coupled\" solves for the viscosity itself",
               std::string("leave models.viscosity = \"") + name_of(plan.viscosity) + "\" out, or choose another pressure", "auto or none");
    if (plan.pressure == PressureModel::coupled && plan.largest_viscosity == 0)
        report("models.pressure", "models.pressure = \"coupled\" needs a viscosity, and fluid.viscosity is 0", "take \"ppe\"");
    const bool right_pressure = plan.boundary == BoundaryModel::none ||
                                (plan.boundary == BoundaryModel::akinci && plan.pressure == PressureModel::wcsph) ||
                                (plan.boundary == BoundaryModel::ppe && plan.pressure == PressureModel::ppe);
    if (!right_pressure)
        report("models.boundary",
               std::string("models.boundary = \"") + name_of(plan.boundary) + "\" does not go with models.pressure = \"" + name_of(plan.pressure) + "\"",
               "take \"auto\"", "akinci with wcsph, ppe with ppe, none with any");
}

}  // namespace whorl

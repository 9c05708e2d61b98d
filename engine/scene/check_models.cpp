#include <fmt/format.h>

#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/scene/checks.h"
#include "engine/scene/names.h"

namespace whorl {

namespace {

/// Beyond it conjugate gradients with the matrix's diagonal alone stall (docs: `whorl stability viscous_steps`).
constexpr double most_assembled_viscous_number = 2e5;

}  // namespace

void check_models(const Scene& scene, const Plan& plan, const SceneNumbers& numbers, std::vector<Problem>& problems) {
    const auto report = [&](const std::string& key, const std::string& what, const std::string& hint, const std::string& allowed = "") {
        problems.push_back({scene.place(key), what, hint, allowed.empty() ? "" : "allowed: " + allowed});
    };
    if (scene.fluid.surface_tension > 0 && plan.pressure == PressureModel::none)
        report("fluid.surface_tension", "surface tension pulls particles together, and models.pressure = \"none\" keeps none apart",
               "choose a pressure");
    if (scene.boundary.gate > 0 && plan.boundary != BoundaryModel::akinci && plan.boundary != BoundaryModel::ppe)
        report("boundary.gate",
               std::string(
                   "boundary.gate belongs to solids of models.pressure = \"wcsph\" or \"ppe\", and this scene has models.pressure = \"") +
                   name_of(plan.pressure) + "\"" + (scene.solids.empty() ? " and no solids" : ""),
               "set boundary.gate = 0");

    if (plan.viscosity == ViscosityModel::full_assembled)
        if (const double bytes = plan.estimated_particles * assembled_bytes(plan.support / plan.spacing); bytes > most_assembled_bytes)
            report("models.viscosity",
                   fmt::format("the matrix of models.viscosity = \"full_assembled\" would take {:.1f} GB ({:.0f} particles)", bytes / 1e9,
                               plan.estimated_particles),
                   "take \"full\", the same without a matrix, or a larger fluid.spacing",
                   fmt::format("up to {:g} GB", most_assembled_bytes / 1e9));

    if (plan.viscosity == ViscosityModel::full_assembled && numbers.viscous_number > most_assembled_viscous_number)
        report("models.viscosity",
               fmt::format("the solver of models.viscosity = \"full_assembled\" does not converge where nu dt/d^2 = {:.2g}",
                           numbers.viscous_number),
               "take \"full\", whose iterations do not grow with it, or smaller steps",
               fmt::format("up to {:g}", most_assembled_viscous_number));

    if (plan.pressure == PressureModel::coupled && plan.viscosity != ViscosityModel::none)
        report("models.viscosity", "models.pressure = \"coupled\" solves for the viscosity itself",
               std::string("leave models.viscosity = \"") + name_of(plan.viscosity) + "\" out, or choose another pressure", "auto or none");
    if (plan.viscosity == ViscosityModel::full && !scene.viscosity.correction &&
        scene.viscosity.preconditioner == ViscousPreconditioner::two_level)
        report("viscosity.preconditioner",
               "viscosity.preconditioner = \"two_level\" needs viscosity.correction: as published, a rotation is no rigid motion",
               "take \"block_jacobi\"", "auto, none or block_jacobi");
    if (plan.pressure == PressureModel::coupled && numbers.least_viscous_number < coupled_works_from)
        report(numbers.thinnest_fluid,
               fmt::format(
                   "{} is {:.3g} Pa s at the start, too thin for models.pressure = \"coupled\": the viscous number nu dt/d^2 is {:.2g} "
                   "(dt: the fastest moves by 0.4 spacings), and coupled works from {:g} on",
                   numbers.thinnest_fluid, numbers.least_viscosity, numbers.least_viscous_number, coupled_works_from),
               "choose models.pressure = \"ppe\" with models.viscosity = \"full\"");
    const bool right_pressure = plan.boundary == BoundaryModel::none ||
                                (plan.boundary == BoundaryModel::akinci && plan.pressure == PressureModel::wcsph) ||
                                (plan.boundary == BoundaryModel::ppe && plan.pressure == PressureModel::ppe);
    if (!right_pressure)
        report("models.boundary",
               std::string("models.boundary = \"") + name_of(plan.boundary) + "\" does not go with models.pressure = \"" +
                   name_of(plan.pressure) + "\"",
               "take \"auto\"", "akinci with wcsph, ppe with ppe, none with any");
    for (std::size_t k = 0; k < scene.solids.size(); ++k)
        if (scene.solids[k].slip == Slip::navier && plan.micropolar != MicropolarModel::none)
            report("solid[" + std::to_string(k) + "].slip",
                   "micropolar fluids stick to a solid or slide along it freely: slip = \"navier\" is for others",
                   "take \"no\" or \"free\", or models.micropolar = \"none\"", "no or free");
    const bool uncorrected =
        plan.viscosity == ViscosityModel::full_assembled || (plan.viscosity == ViscosityModel::full && !scene.viscosity.correction);
    for (std::size_t k = 0; k < scene.solids.size(); ++k)
        if (scene.solids[k].slip == Slip::navier && uncorrected)
            report("solid[" + std::to_string(k) + "].slip",
                   "the viscosity as published, without corrected gradients, has half of the shear where neighbours are missing: it knows "
                   "no slip length",
                   "take models.viscosity = \"full\" with viscosity.correction = true, or \"explicit\"", "no or free");
    check_micropolar(scene, plan, problems);
    check_bodies(scene, plan, problems);
    if (scene.time.sleep == 0) return;
    const auto watchful = [&](const std::string& who) {
        report("time.sleep", "time.sleep puts away fluid that " + who, "take time.sleep = 0", "0");
    };
    if (scene.domain.gravity.depends_on_time()) watchful("a changing gravity moves all of");
    if (!scene.drains.empty()) watchful("a drain has to see at every step");
    if (scene.any_free_solid()) watchful("holds a free body up");
    for (const ProbeKeys& probe : scene.probes)
        if (probe.kind == ProbeKind::coil) watchful("a coil probe has to see at every step");
}

}  // namespace whorl

#include <fmt/format.h>

#include <algorithm>

#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// Above it, conjugate gradients preconditioned with the matrix's diagonal stall (docs: `whorl stability viscous_steps`).
constexpr double most_assembled_viscous_number = 2e5;

/// models.pressure = "ppe"
std::string setting(const char* key, const char* value) { return fmt::format("{} = \"{}\"", key, value); }

/// The first models that solve for pressure and viscosity separately.
std::string solved_apart() {
    const auto pressure = std::find_if(pressure_models().begin(), pressure_models().end(),
                                       [](const auto& row) { return row.solves && !row.solves_viscosity; });
    const auto viscosity = std::find_if(viscosity_models().begin(), viscosity_models().end(), [](const auto& row) { return row.implicit; });
    return setting("models.pressure", pressure->name) + " with " + setting("models.viscosity", viscosity->name);
}

void check_wetting(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    const PressureTraits& pressure = plan.traits.pressure;
    if (!plan.free_surface || scene.fluid.surface_tension == 0) return;
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {
        const SolidKeys& solid = scene.solids[k];
        if (!misses_angle(pressure, solid)) continue;
        const bool slips = pressure.solves_viscosity && solid.slip != Slip::no;
        report(entry_name("solid", k) + ".wetting",
               fmt::format("with {}{}, drops do not meet the solid at the angle of wetting = {:g}",
                           setting("models.pressure", pressure.name), slips ? " and a slip other than \"no\"" : "", solid.wetting),
               "use models.pressure = \"ppe\", or remove fluid.surface_tension",
               pressure.solves_viscosity && !slips ? "allowed: 0 to 0.5" : "");
    }
}

void check_pressure(const Scene& scene, const Plan& plan, const SceneScales& numbers, const KeyProblems& report) {
    const PressureTraits& pressure = plan.traits.pressure;
    const std::string chosen = setting("models.pressure", pressure.name);
    if (scene.fluid.surface_tension > 0 && !pressure.keeps_apart)
        report("fluid.surface_tension", "surface tension pulls particles together, and " + chosen + " keeps none apart",
               "choose a pressure");
    check_wetting(scene, plan, report);
    const bool between_walls = !plan.free_surface && !scene.domain.box().all_periodic();
    if (pressure.form == PressureForm::constraint && between_walls && plan.viscosity == ViscosityModel::none && !scene.any_free_solid())
        report("pressure.form",
               "pressure.form = \"constraint\" gains energy in fluid without viscosity that fills the space between solids: its "
               "corrections in every step set confined fluid in motion",
               "use pressure.form = \"projection\" or \"auto\", or models.viscosity = \"xsph\"");
    if (pressure.has_sound && plan.free_surface && scene.pressure.gradient == GradientForm::difference)
        report("pressure.gradient",
               "pressure.gradient = \"difference\" does not hold a free surface: fluid at rest in a tank starts to move",
               "use \"symmetric\"", "allowed with a free surface: symmetric");
    if (!pressure.solves_viscosity) return;
    if (plan.viscosity != ViscosityModel::none)
        report("models.viscosity", chosen + " solves for the viscosity itself",
               "leave " + setting("models.viscosity", name_of(plan.viscosity)) + " out, or choose another pressure",
               "allowed: auto or none");
    if (numbers.least_viscous_number < pressure.least_viscous_number && !scene.fluid.flow_law().yields())
        report(numbers.least_viscosity_key,
               fmt::format("{} is {:.3g} Pa s at the start, too thin for {}: the viscous number nu dt/d^2 is {:.2g} (in a step dt the "
                           "fastest fluid moves by 0.4 spacings), and {} needs at least {:g}",
                           numbers.least_viscosity_key, numbers.least_viscosity, chosen, numbers.least_viscous_number, pressure.name,
                           pressure.least_viscous_number),
               "choose " + solved_apart());
}

void check_boundary(const Plan& plan, const KeyProblems& report) {
    const PressureTraits& pressure = plan.traits.pressure;
    if (plan.boundary == BoundaryModel::none || plan.boundary == pressure.boundary) return;
    std::string pairs;
    for (const PressureTraits& row : pressure_models())
        if (row.boundary != BoundaryModel::none && pairs.find(row.name) == std::string::npos)
            pairs += fmt::format("{} with {}, ", name_of(row.boundary), row.name);
    report("models.boundary",
           setting("models.boundary", name_of(plan.boundary)) + " does not go with " + setting("models.pressure", pressure.name),
           "use \"auto\"", "allowed: " + pairs + "none with any");
}

void check_assembled(const Plan& plan, double viscous_number, const KeyProblems& report) {
    if (plan.viscosity != ViscosityModel::full_assembled) return;
    const std::string chosen = setting("models.viscosity", plan.traits.viscosity.name);
    if (const double bytes = plan.estimated_particles * assembled_bytes(plan.support / plan.spacing, plan.dimensions());
        bytes > most_assembled_bytes)
        report("models.viscosity",
               fmt::format("the matrix of {} would need {:.1f} GB ({:.0f} particles)", chosen, bytes / 1e9, plan.estimated_particles),
               "use \"full\", the same without a matrix, or a larger fluid.spacing",
               fmt::format("allowed: up to {:g} GB", most_assembled_bytes / 1e9));
    if (viscous_number > most_assembled_viscous_number)
        report("models.viscosity", fmt::format("the solver of {} does not converge where nu dt/d^2 = {:.2g}", chosen, viscous_number),
               "use \"full\", whose iterations do not grow with it, or smaller steps",
               fmt::format("allowed: up to {:g}", most_assembled_viscous_number));
}

void check_viscous_solver(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    if (!plan.traits.viscosity.correction.value_or(true) && scene.viscosity.preconditioner == ViscousPreconditioner::two_level)
        report("viscosity.preconditioner",
               "viscosity.preconditioner = \"two_level\" needs viscosity.correction: without it a rotation is not a rigid motion",
               "use \"block_jacobi\"", "allowed: auto, none or block_jacobi");
}

void check_slip(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    const ViscosityTraits& viscosity = plan.traits.viscosity;
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {
        if (scene.solids[k].slip != Slip::navier) continue;
        const std::string key = entry_name("solid", k) + ".slip";
        if (plan.traits.micropolar.spins)
            report(key, "micropolar fluids stick to a solid or slide along it freely: slip = \"navier\" is for others",
                   "use \"no\" or \"free\", or models.micropolar = \"none\"", "allowed: no or free");
        if (viscosity.viscous && !viscosity.knows_slip_length)
            report(key,
                   "the viscosity without corrected gradients has half of the shear where neighbours are missing: it does "
                   "not support slip lengths",
                   "use models.viscosity = " + described(viscosity_models(), &ViscosityTraits::knows_slip_length), "allowed: no or free");
    }
}

bool weightless(const Scene& scene) { return scene.domain.box().all_periodic() || scene.domain.gravity(0).norm() == 0; }

/// Under pressure, rows of particles that pass each other at constant density must give way: they lock and slip.
void check_yield_under_weight(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    const PressureTraits& pressure = plan.traits.pressure;
    const bool keeps_density = pressure.keeps_apart && !pressure.solves_viscosity && pressure.source != PressureSource::velocity;
    if (!scene.fluid.flow_law().yields() || !keeps_density || weightless(scene)) return;
    const std::string form = pressure.has_sound ? setting("models.pressure", pressure.name)
                             : pressure.source  ? setting("pressure.source", "density")
                                                : setting("pressure.form", "constraint");
    report("fluid.yield_stress",
           "with " + form +
               " fluid under its weight locks and slips like sand: at 1.1 times its yield stress it flows at 0.2 to 1.4 times its speed, "
               "and heaps stay a sixth too high",
           "use models.pressure = \"coupled\"");
}

void check_flow_law(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    if (!scene.fluid.flow_law().acts()) return;
    const std::string key = scene.fluid.flow_law().yields() ? "fluid.yield_stress" : "fluid.flow_index";
    const auto [coldest, warmest] = temperature_range(scene);
    for (const double T : sample_times(coldest, warmest))
        if (const double tau = scene.fluid.yield_stress(0, Vec3d::Zero(), T); !is_viscosity(tau))
            return report(key, fmt::format("{} is {:.4g} Pa at {:.4g} K", key, tau, T), "", allowed_instead_of(tau));
    if (!plan.traits.pressure.solves_viscosity && !plan.traits.viscosity.yields)
        report(key,
               fmt::format("{} makes the viscosity depend on the strain rate, which models.viscosity = {} does not support", key,
                           described(plan.traits.viscosity)),
               "use models.viscosity = " + described(viscosity_models(), &ViscosityTraits::yields) + ", or models.pressure = \"coupled\"");
    if (plan.traits.micropolar.spins)
        report(key, "micropolar fluids have one viscosity, and " + key + " makes it depend on the strain rate",
               "use models.micropolar = \"none\"");
    check_yield_under_weight(scene, plan, report);
}

void check_streams(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    if (plan.traits.pressure.solves_viscosity && !scene.streams.empty())
        report(entry_name("stream", 0), "models.pressure = " + described(plan.traits.pressure) + " does not support streams",
               "use models.pressure = \"ppe\" or \"wcsph\"");
}

void check_ink(const Scene& scene, const KeyProblems& report) {
    if (scene.fluid.ink_diffusion > 0 && !scene.any_ink())
        report("fluid.ink_diffusion", "the scene has no ink", "give a [[block]], [[emitter]] or [[stream]] ink");
}

void check_bodies(const Scene& scene, const Plan& plan, const KeyProblems& report) {
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
            report(name + ".density", name + " is a plane, which has no end: it cannot be a free body", "use a box");
        if (solid.closed())
            report(name + ".density", name + " is a closed container of the fluid: it cannot be a free body",
                   "open it (open = \"top\"), or make a hollow body from a mesh");
        if (solid.slip == Slip::navier)
            report(name + ".slip", "along free bodies the fluid sticks or slides freely: a slip length does not push back on them",
                   "use \"no\" or \"free\"");
        if (solid.position.depends_on_time() || solid.rotation.depends_on_time())
            report(name + ".density", name + " has a density, so forces move it, but its position or rotation depends on t",
                   "give its initial position and rotation without t, and its velocity");
        if (solid.pivot)
            report(name + ".pivot", name + " has a density, so it turns about its centre of mass", "remove pivot, or the density");
    }
    if (!scene.any_free_solid()) return;
    if (!plan.traits.pressure.moves_bodies)
        report("models.pressure",
               "models.pressure = " + described(plan.traits.pressure) + " does not move free bodies (solids with a density)",
               "use " + described(pressure_models(), &PressureTraits::moves_bodies));
    else if (plan.boundary == BoundaryModel::none && plan.traits.pressure.boundary != BoundaryModel::none)
        report("models.boundary", "the fluid acts on free bodies through their boundary particles, and models.boundary is none",
               "use \"auto\"");
    if (!plan.traits.viscosity.moves_bodies)
        report("models.viscosity", "models.viscosity = " + described(plan.traits.viscosity) + " does not move free bodies",
               "use " + described(viscosity_models(), &ViscosityTraits::moves_bodies));
    if (scene.fluid.surface_tension > 0) report("fluid.surface_tension", "surface tension does not pull on free bodies", "use 0");
    if (plan.traits.micropolar.spins) report("models.micropolar", "micropolar fluids do not move free bodies", "use \"none\"");
}

void check_plane(const Scene& scene, const Plan& plan, const KeyProblems& report) {
    if (scene.domain.dimensions == 3) return;
    const std::string here = " in two dimensions (domain.dimensions = 2)";
    if (scene.fluid.surface_tension > 0 && plan.traits.pressure.source != PressureSource::velocity)
        report("fluid.surface_tension", "cohesion between particles is not supported" + here, "use 0, or pressure.form = \"projection\"",
               "allowed: 0");
    if (!scene.vortices.empty())
        report(entry_name("vortex", 0), "closed vortex lines are not supported" + here, "give the velocity of [[block]] as expressions");
    for (std::size_t k = 0; k < scene.probes.size(); ++k)
        if (scene.probes[k].kind == ProbeKind::coil)
            report(entry_name("probe", k) + ".kind", "nothing coils" + here, "", "allowed: every other kind");
    for (const std::string what : {"mesh", "obj", "vdb"})
        if (scene.exported(what))
            report("output.export", "no surface exists to export as \"" + what + "\"" + here, "", "allowed: points, vtk, scene or raw");
}

/// Whether fluid is behind the pipe of a nozzle: with the projection it would flow into the pipe.
bool pipe_in_fluid(const SceneShapes& shapes, const EmitterKeys& e, const Plan& plan) {
    const Vec3 behind = (e.position(0) - (plan.support + 2 * plan.spacing) * e.direction(0).normalized()).cast<Real>();
    return !in_solids(shapes, behind, 0) &&
           std::any_of(shapes.blocks.begin(), shapes.blocks.end(), [&](const auto& b) { return b->distance(behind) < 0; });
}

void check_velocity_source(const Scene& scene, const Plan& plan, const SceneShapes& shapes, const KeyProblems& problem) {
    if (plan.traits.viscosity.smooths)
        problem("models.viscosity",
                "pressure.form = \"projection\" does not run with XSPH: a full box diverges, open tanks were not measured",
                "use models.viscosity = \"explicit\", or pressure.form = \"constraint\"");
    if (!plan.free_surface) return;
    for (std::size_t k = 0; k < scene.solids.size(); ++k)
        if (scene.fluid.surface_tension > 0 && scene.solids[k].wetting != 0.5)
            problem(entry_name("solid", k) + ".wetting",
                    "with pressure.form = \"projection\" a surface meets solids at 90 degrees, wetting = 0.5",
                    "use 0.5, or pressure.form = \"constraint\"", "allowed: 0.5");
    if (scene.fluid.surface_tension > 0 && has_dry_floor(scene, shapes))
        problem("pressure.form",
                "with pressure.form = \"projection\" and surface tension, fluid that covers a solid in part (a drop, a front) does not "
                "meet it at "
                "the angle of its wetting: it spreads, comes off or diverges",
                "use pressure.form = \"constraint\"");
    for (std::size_t k = 0; k < scene.emitters.size(); ++k)
        if (pipe_in_fluid(shapes, scene.emitters[k], plan))
            problem("pressure.form",
                    "pressure.form = \"projection\" lets fluid flow from behind into the pipe of " + entry_name("emitter", k) +
                        ", which lies in the fluid",
                    "use pressure.form = \"constraint\", or \"auto\", which does so");
    for (std::size_t k = 0; k < scene.solids.size(); ++k)
        if (scene.domain.dimensions == 3 && !scene.solids[k].closed() && scene.solids[k].shape.kind != "plane")
            problem("pressure.form",
                    "in 3D with a free surface, pressure.form = \"projection\" diverges next to a solid in the fluid, such as " +
                        entry_name("solid", k),
                    "use pressure.form = \"constraint\", or \"auto\", which does so");
}

void check_projection(const Scene& scene, const Plan& plan, const SceneShapes& shapes, const KeyProblems& problem) {
    if (plan.traits.pressure.source == PressureSource::velocity) check_velocity_source(scene, plan, shapes, problem);
    if (plan.traits.pressure.source == PressureSource::density && !plan.free_surface && weightless(scene))
        problem("pressure.source",
                "pressure.source = \"density\" gains energy in confined fluid without gravity: only weight damps the motion that its "
                "density errors cause",
                "use pressure.source = \"velocity\"");
}

}  // namespace

bool misses_angle(const PressureTraits& pressure, const Scene& scene) {
    return scene.fluid.surface_tension > 0 &&
           std::any_of(scene.solids.begin(), scene.solids.end(), [&](const auto& solid) { return misses_angle(pressure, solid); });
}

void check_models(const Scene& scene, const Plan& plan, const SceneScales& numbers, const SceneShapes& shapes,
                  std::vector<Problem>& problems) {
    const KeyProblems report(scene, problems);
    check_pressure(scene, plan, numbers, report);
    check_boundary(plan, report);
    check_assembled(plan, numbers.viscous_number, report);
    check_viscous_solver(scene, plan, report);
    check_slip(scene, plan, report);
    check_flow_law(scene, plan, report);
    check_micropolar(scene, plan, problems);
    check_bodies(scene, plan, report);
    check_streams(scene, plan, report);
    check_ink(scene, report);
    check_projection(scene, plan, shapes, report);
    check_plane(scene, plan, report);
}

}  // namespace whorl

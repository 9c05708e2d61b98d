#include "engine/scene/plan.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/models/pressure/pressure_multigrid.h"
#include "engine/models/surface_tension/surface_tension.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/numbers.h"

namespace whorl {
namespace {

/// Takes what the user chose, or the automatic choice with its reason.
template <class E>
void choose(Plan& plan, const char* key, E asked, E automatic, const std::string& reason, E& chosen) {
    const bool is_automatic = asked == E::automatic;
    chosen = is_automatic ? automatic : asked;
    plan.choices.push_back({key, name_of(chosen), is_automatic, is_automatic ? reason : "as the scene says"});
}

/// Where viscosity and pressure solved together beat the pressure equation with implicit viscosity: a pour of 40, 12 and 4 times 1e-3 m^2/s
/// (scenes/lava.toml) takes 0.71, 1.04 and 2.7 times its time at viscous numbers of 0.64, 0.19 and 0.064, finer 0.72, 0.82 and 1.4 times
/// at 1.0, 0.3 and 0.1.
constexpr double coupled_above = 0.25;

std::string pressure_reason(PressureModel pressure, const Scene& scene, const SceneNumbers& n) {
    if (scene.models.micropolar != MicropolarModel::none) return "the usual company of micropolar terms; \"ppe\" has them too";
    if (!n.free_surface) return "every axis is periodic: no free surface";
    if (scene.any_free_solid()) return "it moves the free bodies in the same solve";
    if (n.viscous_number > coupled_above && pressure == PressureModel::ppe)
        return fmt::format("viscous number nu dt/d^2 = {:.3g} where {} is least: the flow there hardly diffuses within a step",
                           n.least_viscous_number, n.thinnest_fluid);
    const std::string number = fmt::format("viscous number nu dt/d^2 = {:.3g}", n.viscous_number);
    return pressure == PressureModel::coupled
               ? fmt::format("{} > {:g} with a free surface: viscosity and pressure act together within a step", number, coupled_above)
               : fmt::format("{} <= {:g}: the flow hardly diffuses within a step", number, coupled_above);
}

PressureModel automatic_pressure(const Scene& scene, const SceneNumbers& n) {
    if (scene.models.micropolar != MicropolarModel::none) return PressureModel::wcsph;
    const bool viscous = n.viscous_number > coupled_above && n.least_viscous_number >= coupled_works_from;
    return n.free_surface && viscous && !scene.any_free_solid() ? PressureModel::coupled : PressureModel::ppe;
}

void choose_viscosity(Plan& plan, const Scene& scene, const SceneNumbers& n, double step) {
    ViscosityModel wanted = ViscosityModel::full;
    std::string reason;
    if (plan.pressure == PressureModel::coupled) {
        wanted = ViscosityModel::none;
        reason = "the coupled pressure solves for it";
    } else if (n.viscosity == 0) {
        wanted = ViscosityModel::none;
        reason = "fluid.viscosity is 0";
    } else if (n.explicit_step >= step) {
        wanted = ViscosityModel::explicit_laplacian;
        reason = fmt::format("the stable explicit step {:.3g} s is longer than the flow's {:.3g} s", n.explicit_step, step);
    } else {
        reason = fmt::format("the stable explicit step {:.3g} s is shorter than the flow's {:.3g} s", n.explicit_step, step);
    }
    choose(plan, "models.viscosity", scene.models.viscosity, wanted, reason, plan.viscosity);
    if (plan.viscosity == ViscosityModel::full_assembled) {
        const double bytes = assembled_bytes(plan.support / plan.spacing);
        plan.choices.push_back({"viscosity matrix", fmt::format("{:.3g} GB", plan.estimated_particles * bytes / 1e9), true,
                                fmt::format("{:.1f} kB a particle: two rings of neighbours, 3x3 numbers each", bytes / 1e3)});
    }
}

/// Forces along pairs take their isotropy from the neighbours' fourth moments, which few neighbours on a lattice do not have.
void warn_of_lattice(Plan& plan, const Scene& scene) {
    if (plan.viscosity != ViscosityModel::explicit_laplacian || scene.viscosity.laplacian != LaplacianForm::monaghan) return;
    const LatticeStiffness stiff = monaghan_lattice_stiffness(plan.kernel, plan.support, plan.spacing);
    if (std::max(std::abs(stiff.stretching - 1), std::abs(stiff.shear - 1)) > 0.05)
        plan.warnings.push_back(fmt::format(
            "on a lattice, viscosity.laplacian = \"monaghan\" is {:.2f} times as stiff as it should be in stretching and {:.2f} times in "
            "shear with fluid.support = {:g}; take 4, or \"brookshaw\"",
            stiff.stretching, stiff.shear, plan.support / plan.spacing));
}

/// Particles come to rest with a viscosity of alpha = 0.1: nu = alpha c R/20. The fluid's own counts.
void choose_artificial_viscosity(Plan& plan, const Scene& scene, const SceneNumbers& n) {
    constexpr double enough = 0.1;
    double own = 20 * n.nu / (plan.sound_speed * plan.support);
    std::string reason = fmt::format("what the fluid's viscosity lacks to {:g}", enough);
    if (plan.viscosity == ViscosityModel::none) own = 0, reason = "no viscosity of its own: particles come to rest";
    if (plan.viscosity == ViscosityModel::xsph) own = enough, reason = "XSPH smooths";
    if (plan.micropolar != MicropolarModel::none) own = enough, reason = "the micropolar model's own viscosity alone";
    plan.artificial_viscosity = scene.pressure.artificial_viscosity.value_or(std::max(0.0, enough - own));
    const bool automatic = !scene.pressure.artificial_viscosity;
    plan.choices.push_back({"pressure.artificial_viscosity", fmt::format("{:.2g}", plan.artificial_viscosity), automatic,
                            automatic ? reason : "as the scene says"});
}

void tell_surface_tension(Plan& plan, const Scene& scene) {
    const double tension = scene.fluid.surface_tension, d = plan.spacing;
    if (tension == 0) return;
    plan.choices.push_back(
        {"fluid.surface_tension", fmt::format("{:g}", tension), false,
         fmt::format("pulls between particles over {:g} spacings, {}; without viscosity the step must stay below {:.3g} s", Cohesion::range,
                     plan.pressure == PressureModel::coupled
                         ? fmt::format("which press the inside with {:.3g} Pa", internal_pressure(tension, d))
                         : "of the skin alone",
                     surface_tension_step(scene.fluid.density, d, tension, 0))});
}

/// The choice itself is made step by step, by how many particles press (models/pressure/multigrid.h).
void choose_preconditioner(Plan& plan, const Scene& scene) {
    const double above = scene.pressure.form == PressureForm::constraint ? constraint_multigrid_above : poisson_multigrid_above;
    const bool many = plan.estimated_particles >= above;
    Preconditioner chosen{};
    choose(plan, "pressure.preconditioner", scene.pressure.preconditioner, many ? Preconditioner::multigrid : Preconditioner::jacobi,
           fmt::format("{:.3g} particles; its set-up pays from {:.3g} that press at a time", plan.estimated_particles, above), chosen);
}

void choose_boundary(Plan& plan, const Scene& scene) {
    BoundaryModel wanted = BoundaryModel::none;
    std::string reason = "no solids";
    if (!scene.solids.empty()) switch (plan.pressure) {
            case PressureModel::wcsph: wanted = BoundaryModel::akinci, reason = "solids with weakly compressible pressure"; break;
            case PressureModel::ppe: wanted = BoundaryModel::ppe, reason = "solids with the pressure equation"; break;
            case PressureModel::coupled: reason = "the coupled pressure touches solids by distance: stick or slide"; break;
            default: reason = "no pressure: solids only keep particles out";
        }
    choose(plan, "models.boundary", scene.models.boundary, wanted, reason, plan.boundary);
}

void warn(Plan& plan, const Scene& scene, const SceneNumbers& n, const SceneShapes& shapes) {
    const auto add = [&](std::string text) { plan.warnings.push_back(std::move(text)); };
    if (n.viscosity > 0 && plan.viscosity == ViscosityModel::none && plan.pressure != PressureModel::coupled)
        add(fmt::format("fluid.viscosity = {:.3g} Pa s has no effect: models.viscosity is none", n.viscosity));
    if (plan.viscosity == ViscosityModel::explicit_laplacian && n.explicit_step < 0.2 * n.step)
        add(fmt::format(
            "explicit viscosity needs steps of {:.3g} s where the flow allows {:.3g} s: models.viscosity = \"full\" may be faster",
            n.explicit_step, n.step));
    warn_of_lattice(plan, scene);
    if (n.across < 4)
        add(fmt::format("only {:.1f} particles across {}: details there are lost, take a smaller fluid.spacing", n.across, n.thinnest));
    const bool rubs =
        plan.pressure == PressureModel::coupled ||
        (plan.boundary != BoundaryModel::none && plan.viscosity != ViscosityModel::none && plan.viscosity != ViscosityModel::xsph);
    for (std::size_t k = 0; k < scene.solids.size(); ++k)
        if (scene.solids[k].slip == Slip::navier && !rubs)
            add(fmt::format("solid[{}].slip_length has no effect: no viscosity acts at solids (models.viscosity is {})", k,
                            name_of(plan.viscosity)));
    if (plan.pressure == PressureModel::none) add("models.pressure is none: nothing keeps the particles apart");
    if (plan.pressure == PressureModel::wcsph && scene.pressure.background_pressure > 0 && part_left_empty(scene, shapes) > 0.02)
        add("pressure.background_pressure pushes particles away from a free surface: 0 is right where there is one");
    if (plan.pressure == PressureModel::wcsph && scene.pressure.gradient == GradientForm::difference &&
        plan.shifting == ShiftingModel::none)
        add("pressure.gradient = \"difference\" keeps no particles apart: without models.shifting = \"fickian\" they clump and gain "
            "energy");
    if (plan.sound_speed > 0 && plan.sound_speed < 8 * n.speed)
        add(fmt::format("Mach number {:.2f} (speed {:.3g} m/s, sound {:.3g} m/s): density varies by about {:.0f} %",
                        n.speed / plan.sound_speed, n.speed, plan.sound_speed, 100 * std::pow(n.speed / plan.sound_speed, 2)));
    for (std::size_t i = 0; i < scene.blocks.size(); ++i)
        if (const double part = part_inside_solids(shapes, i, plan.spacing); part > 0.1)
            add(fmt::format("{:.0f} % of block[{}] lies inside solids and is left out", 100 * part, i));
    for (std::size_t i = 0; i < scene.emitters.size(); ++i)
        if (emitted_volume(scene.emitters[i], scene.time.end) == 0)
            add(fmt::format("emitter[{}] lets nothing through before the end of the run", i));
}

}  // namespace

Plan make_plan(const Scene& given) {
    const Scene scene = calibrated(given);
    std::vector<Problem> problems;
    const std::string file = scene.place("").file;
    const SceneShapes shapes = make_shapes(scene, problems);
    if (!problems.empty()) throw InputError(in_order(std::move(problems), file));

    Plan plan;
    const double d = plan.spacing = scene.fluid.spacing;
    // The viscous number decides the pressure model, and the model the support: explicit viscosity is judged at the support it would have.
    const SceneNumbers n = scene_numbers(scene, shapes, scene.fluid.support.value_or(2) * d);
    plan.expected_speed = n.speed;
    plan.largest_viscosity = n.viscosity;
    plan.estimated_particles = n.particles;

    const PressureModel automatic = automatic_pressure(scene, n);
    choose(plan, "models.pressure", scene.models.pressure, automatic, pressure_reason(automatic, scene, n), plan.pressure);
    const bool coupled = plan.pressure == PressureModel::coupled;

    plan.support = scene.fluid.support.value_or(coupled ? 3 : 2) * d;
    plan.kernel = scene.fluid.kernel.value_or(coupled ? KernelKind::wendland_c2 : KernelKind::cubic);
    const std::string of_model = coupled ? "what the coupled pressure was measured with" : "usual";
    plan.choices.push_back(
        {"fluid.kernel", name_of(plan.kernel), !scene.fluid.kernel, scene.fluid.kernel ? "as the scene says" : of_model});
    plan.choices.push_back({"fluid.support", fmt::format("{:g}", plan.support / d), !scene.fluid.support,
                            scene.fluid.support ? "as the scene says" : of_model});

    double step = n.step;
    if (plan.pressure == PressureModel::wcsph) {
        // A fluid at rest still needs sound: as fast as the longest step could resolve.
        double speed = std::max(n.speed, scene.time.cfl * d / scene.time.max_step / 10);
        // As fast as what 2.84 sigma/d, about what the layers of the skin press each other with, would push out: the density then changes
        // by a hundredth.
        if (scene.fluid.surface_tension > 0)
            speed = std::max(speed, std::sqrt(internal_pressure(scene.fluid.surface_tension, d) / scene.fluid.density));
        plan.sound_speed = scene.pressure.sound_speed > 0 ? scene.pressure.sound_speed : 10 * speed;
        step = std::min(step, scene.time.cfl * 0.5 * plan.support / (plan.sound_speed + n.speed));
        plan.choices.push_back({"pressure.sound_speed", fmt::format("{:.3g}", plan.sound_speed), scene.pressure.sound_speed == 0,
                                fmt::format("Mach number {:.2g} at the expected {:.3g} m/s", n.speed / plan.sound_speed, n.speed)});
    }
    choose_viscosity(plan, scene, n, step);
    plan.micropolar = scene.models.micropolar;
    if (plan.pressure == PressureModel::wcsph) choose_artificial_viscosity(plan, scene, n);
    if (plan.micropolar != MicropolarModel::none) choose_micropolar(plan, scene, given, step);
    if (plan.pressure == PressureModel::ppe) choose_preconditioner(plan, scene);
    choose_boundary(plan, scene);
    tell_surface_tension(plan, scene);
    const bool difference = plan.pressure == PressureModel::wcsph && scene.pressure.gradient == GradientForm::difference;
    choose(plan, "models.shifting", scene.models.shifting, coupled || difference ? ShiftingModel::fickian : ShiftingModel::none,
           coupled      ? "stretched threads lose their even spacing"
           : difference ? "the difference gradient keeps no particles apart"
                        : "particles of this model keep apart by themselves",
           plan.shifting);

    if (scene.time.sleep > 0)
        plan.choices.push_back({"time.sleep", fmt::format("{:g}", scene.time.sleep), false,
                                "what moves less than that many spacings in half a second is not solved for"});
    check_models(given, plan, n, problems);
    check_placement(scene, plan, n, shapes, problems);
    check_poisson(scene, plan, shapes, problems);
    if (!problems.empty()) throw InputError(in_order(std::move(problems), file));
    warn(plan, scene, n, shapes);
    if (plan.micropolar != MicropolarModel::none) warn_micropolar(plan, scene);
    return plan;
}

}  // namespace whorl

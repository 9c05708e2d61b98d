#include "engine/scene/plan.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/models/pressure/pressure_multigrid.h"
#include "engine/models/surface_tension/surface_tension.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/scene/as_printed.h"
#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/scene_scales.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// Viscous number above which viscosity and pressure are solved together instead of one after the other. In pours of 0.04, 0.012 and 0.004
/// m^2/s (scenes/lava.toml, viscous numbers 0.68, 0.20 and 0.068) the joint solve needs 0.7, 0.4 and 0.4 of the time, and has errors of 8
/// to 9 % instead of 4 to 9 % (docs/reports/tradeoff.md, lava_viscosity).
constexpr double coupled_above = 0.25;

/// @param open the fluid has a free surface
std::string pressure_reason(PressureModel pressure, const Scene& scene, const SceneScales& n, bool open) {
    if (traits_of(scene.models.micropolar).spins && pressure == PressureModel::wcsph)
        return "usual with micropolar terms and a free surface; \"ppe\" also has them";
    if (!n.free_surface) return "every axis is periodic: no free surface";
    if (scene.any_free_solid() && pressure == PressureModel::ppe) return "it moves the free bodies in the same solve";
    if (pressure == PressureModel::ppe && misses_angle(traits_of(PressureModel::coupled), scene))
        return "drops meet solids at the angle of their wetting";
    if (n.viscous_number > coupled_above && pressure == PressureModel::ppe)
        return fmt::format("viscous number nu dt/d^2 = {:.3g} where {} is least: the flow there hardly diffuses within a step",
                           n.least_viscous_number, n.least_viscosity_key);
    if (pressure == PressureModel::coupled && n.viscous_number <= coupled_above)
        return "under the density constraint of \"ppe\" fluid with a yield stress stands like sand";
    const std::string number = fmt::format("viscous number nu dt/d^2 = {:.3g}", n.viscous_number);
    return pressure == PressureModel::coupled ? fmt::format("{} > {:g}{}: viscosity and pressure act together within a step", number,
                                                            coupled_above, open ? " with a free surface" : "")
                                              : fmt::format("{} <= {:g}: the flow hardly diffuses within a step", number, coupled_above);
}

/// @param open the fluid has a free surface
PressureModel automatic_pressure(const Scene& scene, const SceneScales& n, bool open) {
    if (traits_of(scene.models.micropolar).spins)
        return (open || scene.any_free_solid()) && !misses_angle(traits_of(PressureModel::wcsph), scene) ? PressureModel::wcsph
                                                                                                         : PressureModel::ppe;
    const PressureTraits& coupled = traits_of(PressureModel::coupled);
    const bool viscous =
        scene.fluid.flow_law().yields() || (n.viscous_number > coupled_above && n.least_viscous_number >= coupled.least_viscous_number);
    // In a room full of viscous fluid the projection moves bodies (automatic_pressure_form()).
    const bool fits = n.free_surface && (open || !scene.any_free_solid()) && !misses_angle(coupled, scene);
    return viscous && fits ? PressureModel::coupled : PressureModel::ppe;
}

/// Makes the choices in sequence. Each can read the earlier ones in the plan.
class Planner {
public:
    /// @param given the scene as read @param scene the same scene after calibrated()
    Planner(const Scene& given, const Scene& scene, const SceneShapes& shapes)
        : given_(given), scene_(scene), shapes_(shapes), d_(scene.fluid.spacing),
          n_(scene_scales(scene, shapes, scene.fluid.support.value_or(usual.support) * d_)), step_(n_.step) {}

    Plan plan() {
        tell_numbers();
        choose_pressure();
        choose_kernel();
        plan_.rooms = closed_rooms(scene_, shapes_, plan_.support);
        choose_sound_speed();
        choose_viscosity();
        plan_.micropolar = scene_.models.micropolar;
        plan_.traits.micropolar = traits_of(plan_.micropolar);
        if (plan_.traits.micropolar.spins) choose_micropolar(plan_, scene_, given_, step_, n_.across * d_ / 2);
        choose_artificial_viscosity();
        choose_preconditioner();
        choose_boundary();
        tell_surface_tension();
        choose_shifting();
        check();
        add_warnings(plan_, scene_, n_, shapes_);
        return std::move(plan_);
    }

private:
    /// The viscous number decides the pressure model, and that decides the support. So the explicit step is estimated with the support of
    /// the usual models.
    static constexpr PressureTraits usual{};

    /// Uses the user's choice, or the automatic one with its reason.
    template <class E>
    E choose(const char* key, E asked, E automatic, const std::string& reason) {
        const bool is_automatic = asked == E::automatic;
        const E chosen = is_automatic ? automatic : asked;
        note(key, name_of(chosen), is_automatic, reason);
        return chosen;
    }
    void note(const char* key, std::string value, bool automatic, const std::string& reason) {
        plan_.choices.push_back({key, std::move(value), automatic, automatic ? reason : "as the scene says"});
    }
    void tell_numbers() {
        if (scene_.domain.dimensions == 2)
            plan_.choices.push_back({"domain.dimensions", "2", false, "masses, forces and energies are per metre of depth"});
        if (scene_.models.printed())
            plan_.choices.push_back({"models.notes", "as_printed", false, "values and forms of the notes, listed in docs/physics.md 14"});
        plan_.spacing = d_;
        plan_.expected_speed = n_.speed;
        plan_.largest_viscosity = n_.viscosity;
        if (n_.spun.climb > d_) plan_.turning_vessel = static_cast<int>(n_.spun.solid);
        plan_.estimated_particles = n_.particles;
        plan_.free_surface = !scene_.emitters.empty() || part_left_empty(scene_, shapes_) > next_to_nothing;
    }

    void choose_pressure() {
        const PressureModel automatic = automatic_pressure(scene_, n_, plan_.free_surface);
        plan_.pressure =
            choose("models.pressure", scene_.models.pressure, automatic, pressure_reason(automatic, scene_, n_, plan_.free_surface));
        const PressureForm automatic_form = automatic_pressure_form();
        const PressureForm form = scene_.pressure.form.value_or(automatic_form);
        plan_.traits.pressure = traits_of(plan_.pressure, form, scene_.pressure.source);
        if (plan_.traits.pressure.form) note("pressure.form", name_of(form), !scene_.pressure.form, form_reason());
    }

    /// The projection preserves vortices, but cannot handle fluid that splashes.
    PressureForm automatic_pressure_form() const {
        return plan_.free_surface || moves_bodies() || smoothed() ? PressureForm::constraint : PressureForm::projection;
    }
    /// In viscous fluid the projection moves bodies, because the constraint holds them back (docs/physics.md, section 7).
    bool moves_bodies() const { return scene_.any_free_solid() && n_.viscous_number <= coupled_above; }
    /// XSPH smooths per step, not per time, and the projection has not been measured with it.
    bool smoothed() const { return scene_.models.viscosity == ViscosityModel::xsph; }
    std::string form_reason() const {
        if (plan_.free_surface) return "a free surface may splash; waves that do not break keep their height with projection";
        if (moves_bodies()) return "it moves the free bodies in the same solve";
        if (smoothed()) return "the projection cannot be combined with XSPH";
        return "the fluid fills its space, so nothing splashes, and the projection preserves vortices";
    }

    void choose_kernel() {
        const PressureTraits& own = plan_.traits.pressure;
        plan_.support = scene_.fluid.support.value_or(own.support) * d_;
        plan_.kernel = {scene_.fluid.kernel.value_or(own.kernel), scene_.domain.dimensions};
        note("fluid.kernel", name_of(plan_.kernel.kind), !scene_.fluid.kernel, own.kernel_reason);
        note("fluid.support", fmt::format("{:g}", plan_.support / d_), !scene_.fluid.support, own.kernel_reason);
    }

    void choose_sound_speed() {
        if (!plan_.traits.pressure.has_sound) return;
        // Fluid at rest also needs a speed of sound: the highest that the longest step resolves.
        double speed = std::max(n_.speed, scene_.time.cfl * d_ / scene_.time.max_step / 10);
        // At least the speed that the internal pressure (2.84 sigma/d) of surface tension would cause, so that the density changes by a
        // hundredth.
        if (scene_.fluid.surface_tension > 0)
            speed = std::max(speed, std::sqrt(internal_pressure(scene_.fluid.surface_tension, d_) / scene_.fluid.density));
        plan_.sound_speed = scene_.pressure.sound_speed > 0 ? scene_.pressure.sound_speed : 10 * speed;
        step_ = std::min(step_, scene_.time.cfl * 0.5 * plan_.support / (plan_.sound_speed + n_.speed));
        plan_.choices.push_back({"pressure.sound_speed", fmt::format("{:.3g}", plan_.sound_speed), scene_.pressure.sound_speed == 0,
                                 fmt::format("Mach number {:.2g} at the expected {:.3g} m/s", n_.speed / plan_.sound_speed, n_.speed)});
    }

    void choose_viscosity() {
        ViscosityModel wanted = ViscosityModel::none;
        std::string reason;
        const auto explicit_step = [&](const char* is) {
            return fmt::format("the stable explicit step {:.3g} s is {} than the flow's {:.3g} s", n_.explicit_step, is, step_);
        };
        if (plan_.traits.pressure.solves_viscosity) reason = "the coupled pressure solves for the viscosity";
        else if (n_.viscosity == 0) reason = "fluid.viscosity is 0";
        else if (scene_.fluid.flow_law().acts()) wanted = ViscosityModel::full, reason = "the viscosity depends on the strain rate";
        else if (n_.explicit_step >= step_ && rotation_lost(plan_, scene_, n_, shapes_) > most_rotation_lost)
            wanted = ViscosityModel::full,
            reason = fmt::format("an explicit Laplacian removes {}", rotation_text(plan_, scene_, n_, shapes_));
        else if (n_.explicit_step >= step_) wanted = ViscosityModel::explicit_laplacian, reason = explicit_step("longer");
        else wanted = ViscosityModel::full, reason = explicit_step("shorter");
        plan_.viscosity = choose("models.viscosity", scene_.models.viscosity, wanted, reason);
        plan_.traits.viscosity = traits_of(plan_.viscosity, scene_.viscosity);
        if (plan_.viscosity == ViscosityModel::full_assembled) {
            const double bytes = assembled_bytes(plan_.support / d_, plan_.dimensions());
            note("viscosity matrix", fmt::format("{:.3g} GB", plan_.estimated_particles * bytes / 1e9), true,
                 fmt::format("{:.1f} kB per particle: two rings of neighbours, 3x3 numbers each", bytes / 1e3));
        }
    }

    /// Particles come to rest with a viscosity of alpha = 0.1, nu = alpha c R/(4 (D + 2)). The viscosity of the fluid itself is
    /// subtracted.
    void choose_artificial_viscosity() {
        if (!plan_.traits.pressure.has_sound) return;
        constexpr double enough = 0.1;
        double nu = n_.nu;
        std::string reason = fmt::format("{:g} minus the part of the fluid's viscosity", enough);
        if (!plan_.traits.viscosity.viscous) nu = 0, reason = "no other viscosity brings particles to rest";
        if (plan_.traits.viscosity.smooths)
            nu = xsph_viscosity(scene_.viscosity.alpha, plan_.support, step_), reason = fmt::format("{:g} minus the part of XSPH", enough);
        double own = 4 * (scene_.domain.dimensions + 2) * nu / (plan_.sound_speed * plan_.support);
        if (const MicropolarNumbers& n = plan_.spin; n.composed_coupling > 0)
            own *= (n.viscosity - n.composed_coupling / 2) / n.viscosity,
                reason = "motion between particles that the composed curl does not damp";
        else if (plan_.traits.micropolar.spins) own = enough, reason = "the micropolar model's viscosity suffices";
        plan_.artificial_viscosity = scene_.pressure.artificial_viscosity.value_or(std::max(0.0, enough - own));
        note("pressure.artificial_viscosity", fmt::format("{:.2g}", plan_.artificial_viscosity), !scene_.pressure.artificial_viscosity,
             reason);
    }

    /// The final choice is made in each step, from the number of particles under pressure (models/pressure/pressure_multigrid.h).
    void choose_preconditioner() {
        if (plan_.pressure != PressureModel::ppe) return;
        const double above = plan_.traits.pressure.form == PressureForm::constraint ? constraint_multigrid_above : poisson_multigrid_above;
        const bool many = plan_.estimated_particles >= above;
        const bool asked = plan_.traits.pressure.source == PressureSource::density && scene_.pressure.asks_for_multigrid();
        plan_.preconditioner = choose("pressure.preconditioner", scene_.pressure.preconditioner,
                                      many || asked ? Preconditioner::multigrid : Preconditioner::jacobi,
                                      asked ? std::string("pressure.cycle and pressure.sweeps are its options")
                                            : fmt::format("{:.3g} particles; its set-up pays if {:.3g} are under pressure at the same time",
                                                          plan_.estimated_particles, above));
    }

    void choose_boundary() {
        const bool solids = !scene_.solids.empty();
        const PressureTraits& own = plan_.traits.pressure;
        plan_.boundary = choose("models.boundary", scene_.models.boundary, solids ? own.boundary : BoundaryModel::none,
                                solids ? own.boundary_reason : "no solids");
        if (own.form == PressureForm::projection)  // for the viscosity
            plan_.wall_images =
                std::any_of(scene_.solids.begin(), scene_.solids.end(), [](const SolidKeys& solid) { return solid.slip == Slip::free; });
        if (!solids || own.form != PressureForm::constraint) return;
        const bool plane = scene_.domain.dimensions == 2,
                   reported = scene_.any_probe({ProbeKind::solid, ProbeKind::gauge, ProbeKind::point, ProbeKind::line});
        plan_.wall_images = choose("boundary.images", scene_.boundary.images, plane || reported ? WallImages::flat : WallImages::none,
                                   plane      ? "in 2D they take little time"
                                   : reported ? "probes report forces or pressures"
                                              : "no probe reports a force or a pressure") == WallImages::flat;
    }

    void tell_surface_tension() {
        const double tension = scene_.fluid.surface_tension;
        if (tension == 0) return;
        const bool curves = plan_.traits.pressure.source == PressureSource::velocity, presses = plan_.traits.pressure.solves_viscosity;
        const std::string pulls = fmt::format(
            "pulls between particles over {:g} spacings, {}", Cohesion::range,
            presses ? fmt::format("which press the inside with {:.3g} Pa", internal_pressure(tension, d_)) : "of the skin alone");
        plan_.choices.push_back({"fluid.surface_tension", fmt::format("{:g}", tension), false,
                                 fmt::format("{}; without viscosity the step must stay below {:.3g} s",
                                             curves ? "the pressure on the surface is that times its curvature" : pulls,
                                             surface_tension_step(scene_.fluid.density, d_, tension, 0))});
    }

    void choose_shifting() {
        ShiftingModel shifting = plan_.traits.pressure.shifting;
        std::string reason = plan_.traits.pressure.shifting_reason;
        if (plan_.traits.pressure.has_sound && !plan_.free_surface && plan_.traits.viscosity.viscous)
            shifting = ShiftingModel::fickian, reason = "disordered by shear, particles would have a fifth more viscosity";
        if (plan_.traits.pressure.has_sound && scene_.pressure.gradient == GradientForm::difference)
            shifting = ShiftingModel::fickian, reason = "the difference gradient does not keep particles apart";
        plan_.shifting = choose("models.shifting", scene_.models.shifting, shifting, reason);
    }

    void check() {
        std::vector<Problem> problems;
        check_models(given_, plan_, n_, shapes_, problems);
        check_printed(given_, plan_, problems);
        check_placement(scene_, plan_, n_, shapes_, problems);
        check_unused_keys(given_, plan_, problems);
        if (problems.empty()) return;
        add_likely_causes(problems);
        throw InputError(in_order(std::move(problems), scene_.place("").file));
    }
    /// A wrong unit often causes other problems.
    void add_likely_causes(std::vector<Problem>& problems) const {
        for (const ScaleWarning& warning : warnings_of_scale(scene_, shapes_)) {
            const FileLocation at = scene_.place(warning.key);
            if (std::none_of(problems.begin(), problems.end(), [&](const Problem& p) {
                    return p.place.file == at.file && p.place.line == at.line && p.place.column == at.column;
                }))
                problems.push_back({at, "a likely slip: " + warning.text, "", ""});
        }
    }

    const Scene &given_, &scene_;
    const SceneShapes& shapes_;
    double d_;
    SceneScales n_;
    double step_;  ///< limit from the flow and from sound [s]
    Plan plan_;
};

}  // namespace

Plan make_plan(const Scene& given) {
    const Scene scene = calibrated(given);
    std::vector<Problem> problems;
    const SceneShapes shapes = make_shapes(scene, problems);
    if (!problems.empty()) throw InputError(in_order(std::move(problems), scene.place("").file));
    return Planner(given, scene, shapes).plan();
}

bool starts_full(const Scene& scene) {
    std::vector<Problem> none;
    return part_left_empty(scene, make_shapes(scene, none)) < next_to_nothing;
}

}  // namespace whorl

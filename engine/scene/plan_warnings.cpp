#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>

#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/tree.h"

namespace whorl {

double rotation_lost(const Plan& plan, const Scene& scene, const SceneScales& n, const SceneShapes& shapes) {
    const bool free_surface = n.free_surface && part_left_empty(scene, shapes) > next_to_nothing;
    if (traits_of(scene.models.micropolar).spins) return 0;               // there the rotation becomes spin
    if (plan.traits.pressure.form == PressureForm::projection) return 0;  // it uses another Laplacian
    if (!free_surface || scene.viscosity.without_spin() != LaplacianForm::brookshaw || !(n.speed > 0)) return 0;
    const double radius = n.across * plan.spacing / 2, turn = 2 * std::numbers::pi * radius / n.speed;
    return std::isfinite(radius) ? 1 - std::exp(-n.nu * std::pow(1.84 / radius, 2) * turn) : 0;
}

std::string rotation_text(const Plan& plan, const Scene& scene, const SceneScales& n, const SceneShapes& shapes) {
    return fmt::format("{:.2g} % of the rotation of a body with a free surface within a turn", 100 * rotation_lost(plan, scene, n, shapes));
}

namespace {

class PlanWarnings {
public:
    PlanWarnings(Plan& plan, const Scene& scene, const SceneScales& n, const SceneShapes& shapes)
        : plan_(plan), scene_(scene), n_(n), shapes_(shapes), d_(plan.spacing) {}

    void add_all() {
        warn_of_meshes();
        warn_of_viscosity();
        warn_of_pressure();
        warn_of_placement();
        if (n_.spun.climb > d_ && n_.spun.edge > n_.spun.rim) warn_of_spinning();
        for (ScaleWarning& warning : warnings_of_scale(scene_, shapes_)) add_warning(std::move(warning.text));
        if (plan_.traits.micropolar.spins) warn_micropolar(plan_, scene_);
    }

private:
    void add_warning(std::string text) { plan_.warnings.push_back(std::move(text)); }

    void warn_of_meshes() {
        const auto tell_all = [&](const char* kind, const auto& shapes, const auto& shape_of) {
            for (std::size_t i = 0; i < shapes.size(); ++i)
                for (const std::string& remark : shape_of(shapes[i])->remarks) add_warning(entry_name(kind, i) + ".file: " + remark);
        };
        const auto itself = [](const auto& shape) { return shape; };
        tell_all("block", shapes_.blocks, itself), tell_all("drain", shapes_.drains, itself);
        tell_all("solid", shapes_.solids.all, [](const Solid& solid) { return solid.shape; });
    }

    void warn_of_spinning() {
        add_warning(fmt::format(
            "solid[{}] turns at {:.3g} rad/s: fluid that turns with it climbs to {:.3g} m, and the vessel or the domain ends at {:.3g} m",
            n_.spun.solid, n_.spun.rate, n_.spun.edge, n_.spun.rim));
    }

    void warn_of_viscosity() {
        if (n_.viscosity > 0 && plan_.viscosity == ViscosityModel::none && !plan_.traits.viscous())
            add_warning(fmt::format("fluid.viscosity = {:.3g} Pa s has no effect: models.viscosity is none", n_.viscosity));
        if (plan_.viscosity == ViscosityModel::explicit_laplacian && n_.explicit_step < 0.15 * n_.step)
            add_warning(fmt::format(
                "explicit viscosity needs steps of {:.3g} s, and the flow allows {:.3g} s: models.viscosity = \"full\" may be faster",
                n_.explicit_step, n_.step));
        if (plan_.viscosity == ViscosityModel::explicit_laplacian && rotation_lost(plan_, scene_, n_, shapes_) > most_rotation_lost)
            add_warning(fmt::format("viscosity.laplacian = \"brookshaw\" removes {}: use \"monaghan\", or models.viscosity = \"full\"",
                                    rotation_text(plan_, scene_, n_, shapes_)));
        warn_of_lattice();
        if (n_.across < 4)
            add_warning(fmt::format("only {:.1f} particles across {}: details there are lost, use a smaller fluid.spacing", n_.across,
                                    n_.narrowest));
        const bool viscous_walls =
            plan_.traits.pressure.solves_viscosity || (plan_.boundary != BoundaryModel::none && plan_.traits.viscosity.viscous);
        for (std::size_t k = 0; k < scene_.solids.size(); ++k)
            if (scene_.solids[k].slip == Slip::navier && !viscous_walls)
                add_warning(fmt::format("solid[{}].slip_length has no effect: no viscosity acts at solids (models.viscosity is {})", k,
                                        name_of(plan_.viscosity)));
    }

    /// Forces along pairs are isotropic only if the neighbours' fourth moments are, which few neighbours on a lattice do not provide.
    void warn_of_lattice() {
        if (plan_.viscosity != ViscosityModel::explicit_laplacian || scene_.viscosity.without_spin() != LaplacianForm::monaghan) return;
        const LatticeStiffness stiff = monaghan_lattice_stiffness(plan_.kernel, plan_.support, d_);
        if (std::max(std::abs(stiff.stretching - 1), std::abs(stiff.shear - 1)) > 0.05)
            add_warning(
                fmt::format("on a lattice, viscosity.laplacian = \"monaghan\" is {:.2f} times as stiff as it should be in stretching and "
                            "{:.2f} times in shear with fluid.support = {:g}; use 4, or \"brookshaw\"",
                            stiff.stretching, stiff.shear, plan_.support / d_));
    }

    /// The part of the warning about bodies under the constraint that names a model without this fault, empty if there is none.
    std::string way_to_move_bodies() const {
        if (!plan_.free_surface) return "; pressure.form = \"projection\" moves them right";
        if (n_.least_viscous_number >= traits_of(PressureModel::coupled).least_viscous_number)
            return "; models.pressure = \"coupled\" moves them right";
        return scene_.domain.dimensions == 2 ? "; \"projection\" moves them right, if the surface of the fluid moves gently" : "";
    }
    void warn_of_pressure() {
        if (plan_.pressure == PressureModel::none) add_warning("models.pressure is none: nothing keeps the particles apart");
        if (plan_.traits.pressure.source == PressureSource::density && scene_.pressure.damping == 0)
            add_warning(
                "without pressure.damping, pressure.source = \"density\" shakes particles at walls: fluid at rest trembles, and a full "
                "closed box comes apart where pressure.correction is large");
        if (plan_.traits.pressure.source == PressureSource::velocity && plan_.free_surface)
            add_warning(
                "pressure.form = \"projection\" holds a surface that moves gently: it diverges or loses volume if a column collapses, a "
                "jet lands, a body falls or rises through the surface, a drop lies on a solid, thin fluid turns in a round vessel, or "
                "fluid without weight meets other fluid or turns fast; pressure.form = \"constraint\" holds these");
        if (plan_.traits.pressure.source == PressureSource::velocity && !plan_.free_surface && scene_.domain.gravity(0).norm() > 0)
            for (std::size_t k = 0; k < scene_.solids.size(); ++k)
                if (const double density = scene_.solids[k].density; density > 0 && density < 0.9 * scene_.fluid.density)
                    add_warning(
                        fmt::format("solid[{}] is lighter than the fluid: pressed against another solid it is not stable with "
                                    "pressure.form = \"projection\"; use \"constraint\"",
                                    k));
        if (plan_.traits.pressure.form == PressureForm::constraint && plan_.traits.viscosity.implicit && scene_.any_free_solid())
            add_warning(
                "pressure.form = \"constraint\" holds back bodies in viscous fluid: a cylinder that has sunk by its own diameter sinks at "
                "a quarter of its speed" +
                way_to_move_bodies());
        if (plan_.traits.pressure.form == PressureForm::constraint && !plan_.free_surface && !scene_.any_free_solid())
            add_warning(
                std::string("pressure.form = \"constraint\" takes energy from vortices in fluid that fills its space: of 25 particles "
                            "across, they keep 16 to 38 % where 82 % is right; use \"projection\"") +
                (scene_.models.viscosity == ViscosityModel::xsph ? " and another viscosity than xsph" : ""));
        if (!plan_.traits.pressure.has_sound) return;
        if (scene_.pressure.background_pressure > 0 && part_left_empty(scene_, shapes_) > next_to_nothing)
            add_warning("pressure.background_pressure pushes particles away from the free surface; use 0");
        if (scene_.pressure.gradient == GradientForm::difference && plan_.shifting == ShiftingModel::none)
            add_warning(
                "pressure.gradient = \"difference\" keeps no particles apart: without models.shifting = \"fickian\" they clump and gain "
                "energy");
        if (!scene_.fluid.force.is_zero() && scene_.pressure.sound_speed == 0)
            add_warning(
                fmt::format("pressure.sound_speed = {:.3g} m/s was chosen without the speeds that fluid.force causes; set it to ten times "
                            "the largest of them",
                            plan_.sound_speed));
        if (plan_.sound_speed < 8 * n_.speed)
            add_warning(fmt::format("Mach number {:.2f} (speed {:.3g} m/s, sound {:.3g} m/s): density varies by about {:.0f} %",
                                    n_.speed / plan_.sound_speed, n_.speed, plan_.sound_speed,
                                    100 * std::pow(n_.speed / plan_.sound_speed, 2)));
    }

    void warn_of_placement() {
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i) {
            if (const double part = part_inside_solids(shapes_, i, 0); part > 0.1)
                add_warning(fmt::format("{:.0f} % of block[{}] lies inside solids and is left out", 100 * part, i));
            for (std::size_t k = 0; k < i; ++k)
                if (const double part = part_inside_block(shapes_, i, k, d_ / 2); part > 0.05)
                    add_warning(
                        fmt::format("{:.2g} % of block[{}] lies inside block[{}], where the particles of both have no room; let the blocks "
                                    "touch without an overlap",
                                    100 * part, i, k));
        }
        for (const ClosedRoom& room : plan_.rooms) warn_of_room(room);
        for (std::string& warning : warnings_of_lids(scene_, shapes_)) add_warning(std::move(warning));
    }

    void warn_of_room(const ClosedRoom& room) {
        const double excess = room.fluid + room.coming - room.volume, volume = plan_.particle_volume();
        if (excess < std::max(volume, next_to_nothing * room.volume)) return;
        add_warning(
            fmt::format("more comes than fits: the volume of {} is {:.3g} m^{}, {:.3g} are filled at the start, and {} adds {:.3g} until "
                        "the end, {:.3g} ({:.0f} particles) too much; set a stop, or give the room a drain or an opening",
                        room.text(), room.volume, plan_.dimensions(), room.fluid, room.names(), room.coming, excess, excess / volume));
    }

    Plan& plan_;
    const Scene& scene_;
    const SceneScales& n_;
    const SceneShapes& shapes_;
    double d_;
};

}  // namespace

void add_warnings(Plan& plan, const Scene& scene, const SceneScales& n, const SceneShapes& shapes) {
    PlanWarnings(plan, scene, n, shapes).add_all();
}

}  // namespace whorl

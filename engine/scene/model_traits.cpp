#include "engine/scene/model_traits.h"

#include <algorithm>

#include "engine/core/errors.h"
#include "engine/scene/names.h"

namespace whorl {
namespace {

/// The row of a model and, if the model has rows for an option, of this option.
template <class Traits, class Model, class Option>
const Traits& row_of(const std::vector<Traits>& rows, Model model, std::optional<Option> Traits::*option, Option chosen) {
    const auto found = std::find_if(rows.begin(), rows.end(),
                                    [&](const Traits& row) { return row.model == model && (row.*option).value_or(chosen) == chosen; });
    WHORL_ASSERT(found != rows.end(), "a model without a row");
    return *found;
}

}  // namespace

const std::vector<PressureTraits>& pressure_models() {
    static const std::vector<PressureTraits> rows{
        {.model = PressureModel::none, .name = "none", .boundary_reason = "without a pressure, solids only keep particles out"},
        {.model = PressureModel::wcsph,
         .name = "wcsph",
         .keeps_apart = true,
         .has_sound = true,
         .moves_bodies = true,
         .loosens_lattice = 0.01,
         .boundary = BoundaryModel::akinci,
         .boundary_reason = "solids with weakly compressible pressure"},
        {.model = PressureModel::ppe,
         .name = "ppe",
         .form = PressureForm::constraint,
         .keeps_apart = true,
         .solves = true,
         .makes_density = true,
         .moves_bodies = true,
         .boundary = BoundaryModel::ppe,
         .boundary_reason = "solids with the pressure equation"},
        {.model = PressureModel::ppe,
         .name = "ppe",
         .form = PressureForm::projection,
         .source = PressureSource::velocity,
         .cfl = 0.625,
         .keeps_apart = true,
         .solves = true,
         .makes_density = true,
         .moves_bodies = true,
         .kernel = KernelKind::wendland_c2,
         .support = 3,
         .kernel_reason = "measured with the projection",
         .loosens_lattice = 0.03,
         .boundary = BoundaryModel::ppe,
         .boundary_reason = "solids with the pressure equation",
         .shifting_reason = "the projection spreads its particles evenly itself"},
        {.model = PressureModel::ppe,
         .name = "ppe",
         .form = PressureForm::projection,
         .source = PressureSource::density,
         .keeps_apart = true,
         .solves = true,
         .boundary = BoundaryModel::ppe,
         .boundary_reason = "solids with the pressure equation"},
        {.model = PressureModel::coupled,
         .name = "coupled",
         .keeps_apart = true,
         .solves = true,
         .makes_density = true,
         .solves_viscosity = true,
         .least_viscous_number = 0.04,
         .has_micropolar = false,
         .moves_bodies = true,
         .kernel = KernelKind::wendland_c2,
         .support = 2.4,
         .widest_support = 4,
         .kernel_reason = "measured with the coupled pressure",
         .boundary_reason = "the coupled pressure touches solids by distance: stick or slide",
         .shifting = ShiftingModel::fickian,
         .shifting_reason = "particles of stretched threads become unevenly spaced",
         .bytes_a_particle = 2400},
    };
    return rows;
}

const std::vector<ViscosityTraits>& viscosity_models() {
    static const std::vector<ViscosityTraits> rows{
        {.model = ViscosityModel::none, .name = "none"},
        {.model = ViscosityModel::xsph, .name = "xsph", .smooths = true, .needs_density = true},
        {.model = ViscosityModel::explicit_laplacian,
         .name = "explicit",
         .viscous = true,
         .needs_density = true,
         .knows_slip_length = true},
        {.model = ViscosityModel::full,
         .name = "full",
         .correction = true,
         .viscous = true,
         .implicit = true,
         .knows_slip_length = true,
         .yields = true},
        {.model = ViscosityModel::full,
         .name = "full",
         .correction = false,
         .viscous = true,
         .implicit = true,
         .needs_density = true,
         .moves_bodies = false},
        {.model = ViscosityModel::full_assembled,
         .name = "full_assembled",
         .viscous = true,
         .implicit = true,
         .needs_density = true,
         .moves_bodies = false},
    };
    return rows;
}

const std::vector<MicropolarTraits>& micropolar_models() {
    static const std::vector<MicropolarTraits> rows{
        {.model = MicropolarModel::none, .name = "none"},
        {.model = MicropolarModel::notes, .name = "notes", .spins = true, .coupling_by_mu = 1},
        {.model = MicropolarModel::bender, .name = "bender", .spins = true},
        {.model = MicropolarModel::eringen, .name = "eringen", .spins = true, .viscosity_by_transfer = 1},
    };
    return rows;
}

const PressureTraits& traits_of(PressureModel model, PressureForm form, PressureSource source) {
    const auto& rows = pressure_models();
    const auto found = std::find_if(rows.begin(), rows.end(), [&](const PressureTraits& row) {
        return row.model == model && row.form.value_or(form) == form && row.source.value_or(source) == source;
    });
    WHORL_ASSERT(found != rows.end(), "a model without a row");
    return *found;
}

const ViscosityTraits& traits_of(ViscosityModel model, const ViscosityOptions& options) {
    return row_of(viscosity_models(), model, &ViscosityTraits::correction, options.correction);
}

const MicropolarTraits& traits_of(MicropolarModel model) {
    return *std::find_if(micropolar_models().begin(), micropolar_models().end(), [&](const auto& row) { return row.model == model; });
}

std::string described(const PressureTraits& row) {
    const std::string name = "\"" + std::string(row.name) + "\"";
    if (!row.form) return name;
    std::string with = name + " with pressure.form = \"" + std::string(name_of(*row.form)) + "\"";
    if (row.source == PressureSource::density) with += " and pressure.source = \"density\"";
    return with;
}

std::string described(const ViscosityTraits& row) {
    const std::string name = "\"" + std::string(row.name) + "\"";
    if (!row.correction) return name;
    return name + " with viscosity.correction = " + (*row.correction ? "true" : "false");
}

}  // namespace whorl

#pragma once
/// Traits of the models, one row each. Plan, checks, scene keys, assembly and the prediction of cost read these tables. Other code
/// compares a model's name only to read its options and make its stages.
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/scene.h"

namespace whorl {

struct PressureTraits {
    PressureModel model = PressureModel::none;
    const char* name = "";                      ///< in scene files
    std::optional<PressureForm> form = {};      ///< the row applies only to this pressure.form
    std::optional<PressureSource> source = {};  ///< the row applies only to this pressure.source
    double cfl = 1;                             ///< factor on time.cfl for its steps
    bool keeps_apart = false;                   ///< particles do not clump, which surface tension requires
    bool has_sound = false;                     ///< explicit in time: the steps must resolve sound
    bool solves = false;                        ///< solves a linear system in each step, which has a tolerance
    bool makes_density = false;                 ///< computes the density itself; for the others the stage Density does
    bool solves_viscosity = false;              ///< solves for the viscosity in the same system: needs a viscosity, and excludes all
                                                ///< viscosity models
    /// Smallest SceneScales::least_viscous_number for which it works. "coupled" connects the particles by viscosity; thinner fluid would
    /// break up into drops, and its pools would lose height.
    double least_viscous_number = 0;
    bool has_micropolar = true;  ///< may be combined with micropolar terms
    bool moves_bodies = false;
    KernelKind kernel = KernelKind::cubic;  ///< kernel for "auto"
    double support = 2;                     ///< kernel radius for "auto" [spacings]
    double widest_support = 0;              ///< of particles with few neighbours [spacings]
    const char* kernel_reason = "usual";
    double loosens_lattice = 0;                    ///< random displacement of the particles of a lattice at the start [spacings]
    BoundaryModel boundary = BoundaryModel::none;  ///< how solids act on it; the only alternative is "none"
    const char* boundary_reason = "";
    ShiftingModel shifting = ShiftingModel::none;
    const char* shifting_reason = "particles of this model keep apart by themselves";
    double bytes_a_particle = 800;  ///< without neighbour rows, measured at 3,000 particles
};

struct ViscosityTraits {
    ViscosityModel model = ViscosityModel::none;
    const char* name = "";
    std::optional<bool> correction = {};  ///< the row applies only to this viscosity.correction
    bool viscous = false;                 ///< fluid.viscosity acts, also at solids
    bool smooths = false;                 ///< smooths velocities, without a viscosity of the fluid
    bool implicit = false;                ///< solves a linear system, so it does not limit the step
    bool needs_density = false;
    bool knows_slip_length = false;
    bool yields = false;  ///< supports viscosities that depend on the strain rate (FlowLaw)
    bool moves_bodies = true;
};

/// viscosity = mu + viscosity_by_transfer mu_t, coupling = coupling_by_mu mu + mu_t, with mu = fluid.viscosity and mu_t =
/// micropolar.transfer_viscosity.
struct MicropolarTraits {
    MicropolarModel model = MicropolarModel::none;
    const char* name = "";
    bool spins = false;  ///< particles have a spin
    double viscosity_by_transfer = 0, coupling_by_mu = 0;
};

const std::vector<PressureTraits>& pressure_models();
const std::vector<ViscosityTraits>& viscosity_models();
const std::vector<MicropolarTraits>& micropolar_models();

const PressureTraits& traits_of(PressureModel model, PressureForm form = PressureForm::constraint,
                                PressureSource source = PressureSource::velocity);
const ViscosityTraits& traits_of(ViscosityModel model, const ViscosityOptions& options);
const MicropolarTraits& traits_of(MicropolarModel model);

/// The traits of the models that a plan has chosen, and their joint consequences.
struct ModelTraits {
    PressureTraits pressure;
    ViscosityTraits viscosity;
    MicropolarTraits micropolar;
    /// Whether the fluid's viscosity acts, and whether implicitly.
    bool viscous() const { return pressure.solves_viscosity || viscosity.viscous; }
    bool viscous_implicitly() const { return pressure.solves_viscosity || viscosity.implicit; }
    /// Whether a step includes the stage Density.
    bool needs_density() const { return !pressure.makes_density || viscosity.needs_density || micropolar.spins; }
};

/// Names of the rows for which `wanted` is true, each once.
template <class Traits>
std::vector<std::string> names_of(const std::vector<Traits>& rows, bool Traits::*wanted) {
    std::vector<std::string> names;
    for (const Traits& row : rows)
        if (row.*wanted && (names.empty() || names.back() != row.name)) names.push_back(row.name);
    return names;
}

/// The settings that select a row: "full" with viscosity.correction = false.
std::string described(const PressureTraits& row);
std::string described(const ViscosityTraits& row);
/// Descriptions of all rows for which `wanted` is true: "full" with viscosity.correction = true, "explicit" or "none".
template <class Traits>
std::string described(const std::vector<Traits>& rows, bool Traits::*wanted) {
    std::vector<std::string> all;
    for (const Traits& row : rows)
        if (row.*wanted) all.push_back(described(row));
    std::string text;
    for (std::size_t k = 0; k < all.size(); ++k) text += (k == 0 ? "" : k + 1 < all.size() ? ", " : " or ") + all[k];
    return text;
}

}  // namespace whorl

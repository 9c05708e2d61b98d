#pragma once
/// What a scene requires: models chosen (every "auto" resolved, with the reason), constants derived. Nothing is allocated yet.
#include "engine/scene/closed_rooms.h"
#include "engine/scene/micropolar_coefficients.h"
#include "engine/scene/model_facts.h"

namespace whorl {

/// One decision and why.
struct Choice {
    std::string key, value;
    bool automatic = false;  ///< the scene said "auto"
    std::string reason;      ///< one line with the number that decided
};

struct Plan {
    PressureModel pressure = PressureModel::none;     ///< never automatic
    ViscosityModel viscosity = ViscosityModel::none;  ///< never automatic; none where the pressure model solves for it (coupled)
    MicropolarModel micropolar = MicropolarModel::none;
    BoundaryModel boundary = BoundaryModel::none;
    ShiftingModel shifting = ShiftingModel::none;
    Preconditioner preconditioner = Preconditioner::none;  ///< of the pressure equation, once all fluid is there
    ModelFacts facts;                                      ///< of these models; facts.pressure.form and .source are those chosen

    bool free_surface = true;  ///< fluid does not fill all that solids and periodic axes leave

    double spacing = 0, support = 0;  ///< m
    KernelForm kernel;                ///< of so many dimensions as the flow
    double expected_speed = 0;        ///< m/s: largest of the given speeds and of a free fall through the domain
    double sound_speed = 0;           ///< m/s, wcsph
    double artificial_viscosity = 0;  ///< alpha, wcsph
    double largest_viscosity = 0;     ///< Pa s over blocks and emitters
    MicropolarNumbers spin;           ///< where a micropolar model is chosen
    double estimated_particles = 0;   ///< at the end of the run
    std::vector<ClosedRoom> rooms;    ///< into which emitters open
    std::vector<Choice> choices;
    std::vector<std::string> warnings;

    /// The same with what the plan took in the place of "auto".
    ModelKeys chosen_models(ModelKeys models) const {
        models.pressure = pressure, models.viscosity = viscosity, models.boundary = boundary, models.shifting = shifting;
        return models;
    }
    int dimensions() const { return kernel.dimensions; }
    double particle_volume() const { return power_of(spacing, dimensions()); }  ///< m^3, in two dimensions m^2
};

/// @throws InputError listing all that cannot work (emitter outside the domain, fluid inside a solid, more particles than memory, ...)
Plan make_plan(const Scene& scene);

}  // namespace whorl

#pragma once
/// Plan of a scene: chosen models (every "auto" resolved, with the reason) and derived constants. Nothing is allocated yet.
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "engine/scene/model_traits.h"

namespace whorl {

/// rho Du/Dt = ... + viscosity Lap u + coupling curl w;   micro_inertia rho Dw/Dt = spin_viscosity Lap w + coupling (curl u - 2 w) + rho
/// tau.
///   notes:    viscosity = mu,        coupling = mu + mu_t     (the source notes)
///   bender:   viscosity = mu,        coupling = mu_t          (Bender et al. 2017, whose fluid has mu = 0)
///   eringen:  viscosity = mu + mu_t, coupling = mu_t          (Eringen 1966)
struct MicropolarNumbers {
    double density = 1;                  ///< kg/m^3
    double viscosity = 0, coupling = 0;  ///< Pa s
    double pair_viscosity = 0,
           central_viscosity = 0;  ///< Pa s, the parts of it that the micropolar stage applies, by form of the Laplacian
    double composed_coupling =
        0;                      ///< Pa s, the part of the coupling that acts through the curl of curl u - 2 w, with half of it as viscosity
    double implicit_share = 1;  ///< part of fluid.viscosity that the implicit viscosity applies
    bool slides = false;        ///< fluid can turn as a whole without friction: a free surface, or a round wall that it does not stick to
    double turning_growth = 0;  ///< 1/s, rate at which such a body gains speed; 0: it does not
    double spin_viscosity = 0;  ///< Pa s m^2
    double micro_inertia = 1;   ///< m^2
    bool implicit_exchange = true;

    /// Viscosity for waves much longer than spin_length() [Pa s].
    double effective_viscosity() const { return viscosity - coupling / 2; }
    /// The system feeds energy in, whatever the boundary: its dissipation is viscosity |grad u|^2 - 2 coupling w.curl u + 2 coupling w^2 +
    /// spin_viscosity |grad w|^2. Where the fluid slides, forms of the Laplacian with less torque than the coupling feed energy in, too.
    bool grows() const { return coupling > 2 * viscosity; }
    /// Largest rate of growth of waves between two lengths [m], with an added kinematic viscosity [m^2/s]; 0 if none grows [1/s].
    double wave_growth(double shortest, double longest, double smoothing) const;
    /// Rate of growth of a ball, or a disc in 2D, that turns freely [1/s] (docs/physics.md 8).
    double growth_of_turning(double radius, int dimensions, double smoothing) const;
    /// Waves longer than this grow [m]; infinite if none does, 0 where all do.
    double growing_length() const;
    /// In this time [s] a uniform spin falls to 1/e of itself in fluid at rest.
    double response_time() const { return micro_inertia * density / (2 * coupling); }
    /// Over this length [m] the spin differs from half of the vorticity next to a wall; 0 without a spin viscosity, infinite where grows().
    double spin_length() const;
};

/// The scene with the values of the notes if models.notes asks for them (as_printed()), and with micropolar.effective_viscosity turned
/// into the viscosities and the micro-inertia that give it; itself if it asks for neither.
///
/// All three systems can be given viscosity = coupling = 2 effective_viscosity; then the effective viscosity is as wanted, the coupling is
/// half of what would feed energy in, and the first Laplacian's torque on the orbit balances curl u on the spin. spin_viscosity = 2
/// effective_viscosity l^2 makes the spin length l, and micro_inertia = l^2 lets spin and momentum diffuse alike.
Scene calibrated(const Scene& scene);

/// @param scene calibrated @param viscosity of the model that the plan chose @param slides see MicropolarNumbers
MicropolarNumbers micropolar_numbers(const Scene& scene, const ViscosityTraits& viscosity, bool slides);

struct Plan;
/// Chooses the form of the viscosity and the exchange scheme, and explains the numbers. @param flow_step s, the time step that all else
/// allows @param given the scene as read @param radius of the narrowest body of fluid [m]
void choose_micropolar(Plan& plan, const Scene& scene, const Scene& given, double flow_step, double radius);
void warn_micropolar(Plan& plan, const Scene& scene);
void check_micropolar(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

struct Scene;
struct SceneShapes;

/// The places that an emitter's fluid can reach from its opening: between solids, periodic axes and the pipes of emitters, with no way to a
/// drain or out of the domain, at the start.
struct ClosedRoom {
    Eigen::AlignedBox3d box;  ///< m, about it
    double volume = 0;        ///< m^3 that fluid can fill; in two dimensions m^2
    double fluid = 0;         ///< of that, within blocks at the start
    double coming = 0;        ///< until the end of the run
    std::vector<std::size_t> emitters;
    std::string text() const;   ///< "the closed room from (0, 0, 0) to (1, 1, 1) m"
    std::string names() const;  ///< "emitter[0] and emitter[1]"
};

/// Found on a lattice of half a spacing; a way that is narrower than a tenth of one is none. Scenes with solids that
/// move by expressions, and domains with more than ten million places, are not analysed. @param support of the fluid's kernel [m]
std::vector<ClosedRoom> closed_rooms(const Scene& scene, const SceneShapes& shapes, double support);

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
    bool wall_images = false;  ///< of the fluid in flat walls
    ShiftingModel shifting = ShiftingModel::none;
    Preconditioner preconditioner = Preconditioner::none;  ///< of the pressure equation, once all fluid is there
    ModelTraits traits;                                    ///< of these models; facts.pressure.form and .source are those chosen

    bool free_surface = true;  ///< fluid does not fill all that solids and periodic axes leave

    double spacing = 0, support = 0;  ///< m
    KernelForm kernel;                ///< with the flow's dimensions
    double expected_speed = 0;        ///< m/s: largest of the given speeds and of a free fall through the domain
    double sound_speed = 0;           ///< m/s, wcsph
    double artificial_viscosity = 0;  ///< alpha, wcsph
    double largest_viscosity = 0;     ///< Pa s over blocks and emitters
    int turning_vessel = -1;          ///< upright round solid in which fluid that turns with it climbs by more than a spacing; -1: none
    MicropolarNumbers spin;           ///< where a micropolar model is chosen
    double estimated_particles = 0;   ///< at the end of the run
    std::vector<ClosedRoom> rooms;    ///< into which emitters open
    std::vector<Choice> choices;
    std::vector<std::string> warnings;

    /// The models with the plan's choices instead of "auto".
    ModelKeys chosen_models(ModelKeys models) const {
        models.pressure = pressure, models.viscosity = viscosity, models.boundary = boundary, models.shifting = shifting;
        return models;
    }
    int dimensions() const { return kernel.dimensions; }
    double particle_volume() const { return power_of(spacing, dimensions()); }  ///< m^3, in two dimensions m^2
};

/// @throws InputError listing all that cannot work (emitter outside the domain, fluid inside a solid, more particles than memory, ...)
Plan make_plan(const Scene& scene);

/// Whether solids and blocks leave next to nothing of the domain empty at the start.
bool starts_full(const Scene& scene);

}  // namespace whorl

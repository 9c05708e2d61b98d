#pragma once
/// Plan of a scene: chosen models (every "auto" resolved, with the reason) and derived constants. Nothing is allocated yet.
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "engine/core/types.h"
#include "engine/scene/model_traits.h"

namespace whorl {

/// Coefficients of the micropolar equations
///   rho Du/Dt = ... + viscosity Lap u + coupling curl w
///   micro_inertia rho Dw/Dt = spin_viscosity Lap w + coupling (curl u - 2 w) + rho tau
///   notes:    viscosity = mu,        coupling = mu + mu_t     (the source notes)
///   bender:   viscosity = mu,        coupling = mu_t          (Bender et al. 2017, whose fluid has mu = 0)
///   eringen:  viscosity = mu + mu_t, coupling = mu_t          (Eringen 1966)
struct MicropolarNumbers {
    double density = 1;                  ///< kg/m^3
    double viscosity = 0, coupling = 0;  ///< Pa s
    double pair_viscosity = 0,
           central_viscosity = 0;  ///< parts of the viscosity that the micropolar stage applies, by form of the Laplacian [Pa s]
    double composed_coupling = 0;  ///< part of the coupling that acts through the curl of curl u - 2 w, with half of it as viscosity [Pa s]
    double implicit_share = 1;     ///< part of fluid.viscosity that the implicit viscosity applies
    bool slides = false;        ///< fluid can turn as a whole without friction: at a free surface, or along a round wall to which it does
                                ///< not stick
    double turning_growth = 0;  ///< rate at which the speed of fluid that slides grows, 0: none [1/s]
    double spin_viscosity = 0;  ///< Pa s m^2
    double micro_inertia = 1;   ///< m^2
    bool implicit_exchange = true;

    /// Viscosity for waves much longer than spin_length() [Pa s].
    double effective_viscosity() const { return viscosity - coupling / 2; }
    /// Whether the system gains energy for any boundary. Its dissipation is viscosity |grad u|^2 - 2 coupling w.curl u + 2 coupling w^2 +
    /// spin_viscosity |grad w|^2. If the fluid slides, forms of the Laplacian with less torque than the coupling also add energy.
    bool grows() const { return coupling > 2 * viscosity; }
    /// Largest growth rate [1/s] of waves between two lengths [m], with an added kinematic viscosity `smoothing` [m^2/s]; 0 if none grows.
    double wave_growth(double shortest, double longest, double smoothing) const;
    /// Growth rate of a ball (2D: a disc) that turns freely [1/s] (docs/physics.md 8).
    double growth_of_turning(double radius, int dimensions, double smoothing) const;
    /// Waves longer than this length grow [m]; infinite if none grows, 0 if all grow.
    double growing_length() const;
    /// Time in which a uniform spin in fluid at rest falls to 1/e [s].
    double response_time() const { return micro_inertia * density / (2 * coupling); }
    /// Distance from a wall over which the spin differs from half of the vorticity [m]; 0 without a spin viscosity, infinite if grows().
    double spin_length() const;
};

/// The scene with the values of the notes if models.notes requires them (as_printed()), and with micropolar.effective_viscosity converted
/// into the viscosities and the micro-inertia that give it. The same scene if neither is set. In all three systems viscosity = coupling =
/// 2 effective_viscosity is possible. Then the effective viscosity is as requested, the coupling is half of the value at which energy
/// grows, and the first Laplacian's torque on the orbit balances curl u on the spin. spin_viscosity = 2 effective_viscosity l^2 makes the
/// spin length l, and with micro_inertia = l^2 spin and momentum diffuse equally fast.
Scene calibrated(const Scene& scene);

/// @param scene calibrated @param viscosity traits of the chosen viscosity model @param slides see MicropolarNumbers
MicropolarNumbers micropolar_numbers(const Scene& scene, const ViscosityTraits& viscosity, bool slides);

struct Plan;
/// Chooses the form of the viscosity and the exchange scheme, and adds the numbers to the plan's choices. @param flow_step time step that
/// all other limits allow [s] @param given the scene as read @param radius of the narrowest body of fluid [m]
void choose_micropolar(Plan& plan, const Scene& scene, const Scene& given, double flow_step, double radius);
void warn_micropolar(Plan& plan, const Scene& scene);
void check_micropolar(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

struct Scene;
struct SceneShapes;

/// The region that an emitter's fluid can reach from the opening at the start, bounded by solids and the pipes of emitters, with no way to
/// a drain or out of the domain.
struct ClosedRoom {
    Eigen::AlignedBox3d box;  ///< bounding box [m]
    double volume = 0;        ///< volume that fluid can fill [m^3], in 2D area [m^2]
    double fluid = 0;         ///< part of it within blocks at the start
    double coming = 0;        ///< volume that emitters add until the end of the run
    std::vector<std::size_t> emitters;
    std::string text() const;   ///< "the closed room from (0, 0, 0) to (1, 1, 1) m"
    std::string place() const;  ///< "from (0, 0, 0) to (1, 1, 1) m"
    std::string names() const;  ///< "emitter[0] and emitter[1]"
};

/// Closed rooms, found on a lattice of half a spacing. A gap narrower than a tenth of a spacing counts as closed. Scenes with solids that
/// move by expressions and domains with more than ten million lattice points are not analysed. @param support of the fluid's kernel [m]
std::vector<ClosedRoom> closed_rooms(const Scene& scene, const SceneShapes& shapes, double support);

/// One decision with its reason.
struct Choice {
    std::string key, value;
    bool automatic = false;  ///< the scene gave "auto"
    std::string reason;      ///< one line, with the number that decided
};

struct Plan {
    PressureModel pressure = PressureModel::none;     ///< never automatic
    ViscosityModel viscosity = ViscosityModel::none;  ///< never automatic; none if the pressure model solves for it (coupled)
    MicropolarModel micropolar = MicropolarModel::none;
    BoundaryModel boundary = BoundaryModel::none;
    bool wall_images = false;  ///< use images of the fluid in flat walls
    ShiftingModel shifting = ShiftingModel::none;
    Preconditioner preconditioner = Preconditioner::none;  ///< of the pressure equation, when all fluid is present
    ModelTraits traits;                                    ///< traits of these models; traits.pressure.form and .source are the chosen
                                                           ///< ones

    bool free_surface = true;  ///< the fluid does not fill everything that solids and periodic axes leave

    double spacing = 0, support = 0;  ///< m
    KernelForm kernel;                ///< kind, and dimensions of the flow
    double expected_speed = 0;        ///< largest of the speeds in the scene and of a free fall through the domain [m/s]
    double sound_speed = 0;           ///< m/s, wcsph
    double artificial_viscosity = 0;  ///< alpha, wcsph
    double largest_viscosity = 0;     ///< Pa s over blocks and emitters
    int turning_vessel = -1;          ///< index of an upright round solid in which fluid that turns with it climbs by more than a spacing;
                                      ///< -1: none
    MicropolarNumbers spin;           ///< set if a micropolar model is chosen
    double estimated_particles = 0;   ///< at the end of the run
    std::vector<ClosedRoom> rooms;    ///< rooms into which emitters open
    std::vector<Choice> choices;
    std::vector<std::string> warnings;

    /// `models` with the plan's choices in place of "auto".
    ModelKeys chosen_models(ModelKeys models) const {
        models.pressure = pressure, models.viscosity = viscosity, models.boundary = boundary, models.shifting = shifting;
        return models;
    }
    int dimensions() const { return kernel.dimensions; }
    double particle_volume() const { return power_of(spacing, dimensions()); }  ///< m^3, in two dimensions m^2
};

/// @throws InputError with all faults of the scene (emitter outside the domain, fluid inside a solid, more particles than memory, ...)
Plan make_plan(const Scene& scene);

/// Whether solids and blocks leave at most 2 % of the domain empty at the start.
bool starts_full(const Scene& scene);

}  // namespace whorl

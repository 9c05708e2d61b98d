#pragma once
/// What the micropolar keys of a scene mean: the coefficients of the system, and the lengths and times behind them.
#include "engine/scene/model_facts.h"

namespace whorl {

/// rho Du/Dt = ... + viscosity Lap u + coupling curl w;   micro_inertia rho Dw/Dt = spin_viscosity Lap w + coupling (curl u - 2 w) + rho
/// tau.
///   seed:     viscosity = mu,        coupling = mu + mu_t     (the source notes)
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

    /// What waves long beside spin_length() feel [Pa s].
    double effective_viscosity() const { return viscosity - coupling / 2; }
    /// The system feeds energy in, whatever the boundary: its dissipation is viscosity |grad u|^2 - 2 coupling w.curl u + 2 coupling w^2 +
    /// spin_viscosity |grad w|^2. Where the fluid slides, forms of the Laplacian with less torque than the coupling feed energy in, too.
    bool grows() const { return coupling > 2 * viscosity; }
    /// Largest rate of growth of waves between two lengths [m], with an added kinematic viscosity [m^2/s]; 0 if none grows [1/s].
    double wave_growth(double shortest, double longest, double smoothing) const;
    /// Rate of growth of a ball, or a disc in 2D, that turns freely [1/s] (docs/physics.md 8).
    double growth_of_turning(double radius, int dimensions, double smoothing) const;
    /// Waves longer than this grow [m]; infinite where none does, 0 where all do.
    double growing_length() const;
    /// In this time [s] a uniform spin falls to 1/e of itself in fluid at rest.
    double response_time() const { return micro_inertia * density / (2 * coupling); }
    /// Over this length [m] the spin differs from half of the vorticity next to a wall; 0 without a spin viscosity, infinite where grows().
    double spin_length() const;
};

/// The scene with micropolar.effective_viscosity turned into the viscosities and the micro-inertia that give it; itself where it asks for
/// none.
///
/// All three systems can be given viscosity = coupling = 2 effective_viscosity; then the effective viscosity is as wanted, the coupling is
/// half of what would feed energy in, and the first Laplacian's torque on the orbit balances curl u on the spin. spin_viscosity = 2
/// effective_viscosity l^2 makes the spin length l, and micro_inertia = l^2 lets spin and momentum diffuse alike.
Scene calibrated(const Scene& scene);

/// @param scene calibrated @param viscosity of the model that the plan chose @param slides see MicropolarNumbers
MicropolarNumbers micropolar_numbers(const Scene& scene, const ViscosityFacts& viscosity, bool slides);

struct Plan;
/// Chooses the form of the viscosity and the exchange scheme, and explains the numbers. @param flow_step s, the time step that all else
/// allows @param given the scene as read @param radius of the narrowest body of fluid [m]
void choose_micropolar(Plan& plan, const Scene& scene, const Scene& given, double flow_step, double radius);
void warn_micropolar(Plan& plan, const Scene& scene);
void check_micropolar(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

}  // namespace whorl

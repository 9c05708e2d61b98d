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
    double spin_viscosity = 0;     ///< Pa s m^2
    double micro_inertia = 1;      ///< m^2
    bool implicit_exchange = true;

    /// What waves long beside spin_length() feel [Pa s].
    double effective_viscosity() const { return viscosity - coupling / 2; }
    /// The system feeds energy in: its dissipation is viscosity |grad u|^2 - 2 coupling w.curl u + 2 coupling w^2 + spin_viscosity |grad
    /// w|^2.
    bool grows() const { return coupling > 2 * viscosity; }
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

/// @param scene calibrated @param viscosity of the model that the plan chose
MicropolarNumbers micropolar_numbers(const Scene& scene, const ViscosityFacts& viscosity);

struct Plan;
/// Chooses the exchange scheme and explains the numbers. @param flow_step s, the time step that all else allows @param given the scene as
/// read
void choose_micropolar(Plan& plan, const Scene& scene, const Scene& given, double flow_step);
void warn_micropolar(Plan& plan, const Scene& scene);
void check_micropolar(const Scene& scene, const Plan& plan, std::vector<Problem>& problems);

}  // namespace whorl

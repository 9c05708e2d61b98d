#pragma once
/// Micropolar fluid: every particle has a spin that is coupled with the flow (docs/physics.md 8).
///
/// Stages of a step: Density, pressure (weakly compressible), Gravity, Micropolar, Kick, (implicit viscosity), (pressure equation), Move.
/// Micropolar must be the last stage that adds to the acceleration, so that its energy budget is exact.
#include <memory>

#include "engine/math/expression_field.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/sph/curl.h"
#include "engine/sph/gate.h"

namespace whorl {

namespace field {
struct spin_change {
    using type = Vec3;
    static constexpr std::string_view name = "spin_change", unit = "1/s", meaning = "change of the spin in this step";
};
}  // namespace field

/// rho Du/Dt = ... + mu Lap u + lambda curl w;   theta rho Dw/Dt = gamma Lap w + lambda (curl u - 2 w) + rho tau
/// u is the velocity, w the spin, lambda the coupling, theta the micro-inertia and tau the torque per mass. The choice of mu and lambda
/// gives one of the published systems (engine/scene/plan.h).
struct MicropolarOptions {
    double coupling = 0;           ///< lambda [Pa s]
    double composed_coupling = 0;  ///< part of the coupling that acts through -(1/2) curl (curl u - 2 w) [Pa s]
    double pair_viscosity = 0;     ///< mu of the first Laplacian, along the difference of velocities [Pa s]
    double central_viscosity = 0;  ///< mu of the second Laplacian, along the pair: no torque [Pa s]
    double spin_viscosity = 0;     ///< gamma [Pa s m^2]
    double micro_inertia = 1;      ///< theta [m^2]
    CurlForm curl_velocity = CurlForm::difference_own_density, curl_spin = CurlForm::symmetric;
    /// true: curl u - 2 w is computed as the curl of the velocity relative to the turning particle, u_j - u_i - w_i x (x_j - x_i). Then a
    /// rigid rotation with the matching spin has no exchange, even at a free surface, and the orbital motion gains the angular momentum
    /// that the spin loses. false: curl u - 2 w as printed.
    bool co_rotating = true;
    bool implicit_exchange = true;                      ///< true: the decay of the spin is implicit and does not limit the step
    double smoothing_velocity = 0, smoothing_spin = 0;  ///< fractions of XSPH per smoothing_time
    double smoothing_time = 0;                          ///< [s]; 0: the fractions apply to each step
    /// Fraction that a step of dt [s] applies. @param given smoothing_velocity or smoothing_spin
    Real part_a_step(double given, Real dt) const {
        return static_cast<Real>(smoothing_time > 0 ? std::min(0.5, given * static_cast<double>(dt) / smoothing_time) : given);
    }
    /// true: sums as in the notes, without lattice factors, with the weights m/rho_j in the Laplacians. This stage then leaves out the
    /// smoothing, which follows the kick (XsphViscosity, XsphSpin).
    bool printed = false;
    /// true: one stage per step where the rates allow it, if an implicit viscosity of first order is part of the step (CorrectedMicropolar)
    bool one_stage = false;
    bool free_spin_walls = false;  ///< no couple stress at walls; false: the fluid's spin at a wall is the solid's rotation
    VectorExpression torque;       ///< tau, of t, x, y, z [m^2/s^2]
    Real solid_factor = 1;         ///< factor on the volumes of boundary particles, see models/boundary/wall.h
    SolidGate gate;
};

/// Stage that computes all sums in one pass over the pairs. The lattice factors are those of ExplicitViscosity (docs/physics.md 4). The
/// curls have the factor of the first Laplacian, which makes the curls exact for linear fields on a lattice.
///
/// Conservation of angular momentum. With curl_spin = symmetric, curl_velocity = difference_own_density and co_rotating, the orbital motion
/// gains the angular momentum that -2 w takes from the spin. If pair_viscosity = coupling, the torque of the first Laplacian balances curl
/// u. Under these conditions the sum of orbital angular momentum and spin is constant to round-off for any shape of the surface.
class Micropolar {
public:
    explicit Micropolar(MicropolarOptions options);
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::density> rho,
                    Read<field::position> x, Read<field::velocity> u, Update<field::acceleration> a, Write<field::spin_change> change,
                    Update<field::spin> w);

private:
    template <class Kernel, class Form>
    EnergyWork advance(const Kernel& kernel, const InteractionContext& context, Read<field::role> role, Read<field::density> rho,
                       Read<field::velocity> u, Update<field::acceleration> a, Write<field::spin_change> change, Read<field::spin> w);
    MicropolarOptions options_;
    ExpressionField torque_;
    Column<Vec3> push_;  ///< spin field, including the composed part, whose curl accelerates the flow; scratch of a step
};

/// Longest step of the explicit exchange [s]. With kappa = lambda/rho and k the largest eigenvalue of the curl on the lattice [1/m], the
/// exchange alone has the rates kappa/theta (1 +- sqrt(1 + theta k^2)). The result is the inverse of the larger rate. Such a step is stable
/// together with the explicit Laplacians, and the spin does not overshoot.
double exchange_step(double kinematic_coupling, double micro_inertia, double largest_curl);

}  // namespace whorl

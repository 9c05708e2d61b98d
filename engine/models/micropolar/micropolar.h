#pragma once
/// Micropolar fluid: every particle has a spin, which the flow turns and which acts on the flow (docs/physics.md 8).
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
/// with lambda the coupling. mu and lambda decide which of the published systems this is (engine/scene/plan.h).
struct MicropolarOptions {
    double coupling = 0;           ///< lambda [Pa s]
    double composed_coupling = 0;  ///< part of the coupling that acts through -(1/2) curl (curl u - 2 w) [Pa s]
    double pair_viscosity = 0;     ///< mu of the first Laplacian, along the difference of velocities [Pa s]
    double central_viscosity = 0;  ///< mu of the second Laplacian, along the pair: no torque [Pa s]
    double spin_viscosity = 0;     ///< gamma [Pa s m^2]
    double micro_inertia = 1;      ///< theta [m^2]
    CurlForm curl_velocity = CurlForm::difference_own_density, curl_spin = CurlForm::symmetric;
    /// true: curl u - 2 w is the curl of the velocity relative to the turning particle, u_j - u_i - w_i x (x_j - x_i). A rigid rotation
    /// whose spin matches has no exchange, also at a free surface, and the orbital motion gains the angular momentum that the spin loses.
    /// false: curl u - 2 w as printed.
    bool co_rotating = true;
    bool implicit_exchange = true;                      ///< the spin's decay is implicit: it does not limit the step
    double smoothing_velocity = 0, smoothing_spin = 0;  ///< XSPH, fractions per step ...
    double smoothing_time = 0;                          ///< ... or per this time [s]; 0: per step
    /// Fraction that a step of dt [s] applies. @param given smoothing_velocity or smoothing_spin
    Real part_a_step(double given, Real dt) const {
        return static_cast<Real>(smoothing_time > 0 ? std::min(0.5, given * static_cast<double>(dt) / smoothing_time) : given);
    }
    /// Sums of the notes: no lattice factors, Laplacians with the weights m/rho_j. Smoothing is not part of this stage; it follows the kick
    /// (XsphVelocity).
    bool printed = false;
    bool free_spin_walls = false;  ///< no couple stress at walls; false: the fluid's spin at a wall is the solid's rotation
    VectorExpression torque;       ///< tau, of t, x, y, z [m^2/s^2]
    Real solid_factor = 1;         ///< on the solids' volumes, see models/boundary/wall.h
    SolidGate gate;
};

/// Computes all sums in one pass over the pairs. The lattice factors are those of ExplicitViscosity (docs/physics.md 4). The curls have the
/// factor of the first Laplacian, which makes them exact for linear fields on a lattice.
///
/// Conservation: with the curls symmetric (spin) and difference_own_density (velocity) and co_rotating, the orbital motion gains what -2 w
/// takes from the spin. The torque of the first Laplacian balances curl u if pair_viscosity = coupling. The sum of both angular momenta is
/// then constant to round-off for any shape of the surface.
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
    Column<Vec3> push_;  ///< spin field whose curl pushes the flow, with the composed part; scratch of a step
};

/// Longest step of the explicit exchange [s]. With kappa = lambda/rho and k the largest curl on the lattice, the exchange alone has the
/// rates kappa/theta (1 +- sqrt(1 + theta k^2)). The inverse of the larger rate is stable together with the explicit Laplacians, and the
/// spin does not overshoot.
double exchange_step(double kinematic_coupling, double micro_inertia, double largest_curl);

}  // namespace whorl

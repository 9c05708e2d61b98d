#pragma once
/// Temperature of the fluid: conduction, solids, air, radiation, melting.
#include <vector>

#include "engine/models/temperature/half_space.h"
#include "engine/models/temperature/heat_options.h"
#include "engine/models/temperature/temperature.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// m dh_i/dt = sum_j k V^2 |W'|/r (n_i + n_j) (T_j - T_i) + sum_w G_iw (T_w - T_i) + A_iw q + a_i U (T_air - T_i)
///
/// The pair form of Cleary and Monaghan (1999, doi:10.1006/jcph.1998.6118), with the factors n = D/(sum_j V |W'| r) that make the Laplacian
/// right on uneven particles, as for ink (sph/laplacian_moment.h). Exchanges are antisymmetric in the pair, so heat is conserved to
/// round-off. The temperature is found by backward Euler with conjugate gradients, stable for any step, and the enthalpy then changes by
/// the exchanges of the solution: an unfinished solve does not change the total.
///
/// Solids: behind the surface the temperature continues linearly to the wall's at the surface, so G = A/(s/k + 1/film), with the distance s
/// from the surface and the wall's area A that belongs to the particle (HalfSpace). A heat flux enters through the same area.
///
/// Air: U = 1/(d/(2 k) + 1/(film + eps sigma (T^2 + T_air^2)(T + T_air))), through the area that the particle shows. Particles inside
/// nozzles show none.
class Heat {
public:
    Heat(const HeatOptions& options, std::vector<SolidHeat> solids) : options_(options), solids_(std::move(solids)) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                    Update<field::temperature> T, Update<field::temperature_rest> rest);

private:
    void find_moments(const InteractionContext& context);
    void touch_solids(const InteractionContext& context, Read<field::position> x, Span<const Real> T);
    void meet_air(const InteractionContext& context, Read<field::role> role, Read<field::position> x, Span<const Real> T);
    void weigh_pairs(const InteractionContext& context);
    SolveReport solve(const Pairs& pairs, Span<const Real> T, Span<const Real> rest, const StepContext& step);

    HeatOptions options_;
    std::vector<SolidHeat> solids_;
    HalfSpace half_space_;
    // Values of one step.
    std::vector<Real> moment_;              ///< sum_j V |W'| r; then n
    std::vector<Real> conductance_, gain_;  ///< of solids and air [W/K], and what they give at the temperature before the step [W]
    std::vector<Real> change_;              ///< of the temperature [K]
    Column<Real> pair_;                     ///< k V^2 |W'|/r (n_i + n_j) by pair [W/K]
    Column<Vec3> lacking_;                  ///< points to where neighbours lack
};

}  // namespace whorl

#include "engine/models/viscosity/full.h"

namespace whorl {

void FullViscosity::operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                               const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x, Read<field::viscosity> mu,
                               Update<field::velocity> u, Update<field::viscous_acceleration> last) {
    operator_.set_up(options_, pairs, solid_pairs, solids, layer, step, role, mu);
    solve_implicit(operator_, options_.limits, {step, report, role, x, u, last});
}

void UncorrectedViscosity::operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const Solids& solids, const SolidParticles& layer,
                                      const StepContext& step, StepReport& report, Read<field::role> role, Read<field::position> x,
                                      Read<field::density> rho, Read<field::viscosity> mu, Update<field::velocity> u,
                                      Update<field::viscous_acceleration> last) {
    operator_.set_up(options_, pairs, solid_pairs, solids, layer, step, role, mu, rho.values);
    solve_implicit(operator_, options_.limits, {step, report, role, x, u, last});
}

}  // namespace whorl

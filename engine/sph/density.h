#pragma once
/// Density by kernel sums.
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/sph/gate.h"

namespace whorl {

/// rho_i = m W_ii + sum_j m W_ij + rho_0 sum_s f V_s W_is. Solids contribute through their volumes V_s (Akinci et al. 2012).
/// @param solid_factor f, see models/boundary/wall.h @param density [kg/m^3], written
void sum_density(const InteractionContext& context, Real solid_factor, SolidGate gate, Span<Real> density);

/// Stage that computes sum_density().
struct Density {
    Real solid_factor = 1;
    SolidGate gate = {};
    void operator()(const InteractionContext& context, Write<field::density> rho) const {
        sum_density(context, solid_factor, gate, rho.values);
    }
};

}  // namespace whorl

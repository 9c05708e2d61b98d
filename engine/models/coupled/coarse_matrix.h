#pragma once
#include "engine/math/block_cholesky.h"
#include "engine/models/coupled/strain_form.h"
#include "engine/particles/aggregates.h"

namespace whorl {

/// Ac = R^T (1 + K) R for the rigid motions of the aggregates. Particles in none are held.
SymmetricBlocks coarse_matrix(const StrainForm& form, const RigidAggregates& aggregates);

}  // namespace whorl

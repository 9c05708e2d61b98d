#pragma once
/// Multigrid preconditioners of the two pressure solves (docs/reports/pressure.md).
#include "engine/math/multigrid.h"
#include "engine/models/pressure/constraint.h"
#include "engine/models/pressure/poisson.h"

namespace whorl {

/// How the particles sit on the first coarse level, and how the two are joined.
struct ParticleMultigrid {
    Real cell;             ///< in spacings: the unknowns of a cubic cell make one coarse unknown
    bool additive = true;  ///< z = D^-1 r + P M P^T r; false: a V-cycle from the particles on, with the sweeps of `coarse`
    MultigridOptions coarse;
};

/// An odd number of spacings: constants over an even one look like the alternating modes that the constraint's gradient does not see.
inline constexpr ParticleMultigrid constraint_levels{7, true, {}};
inline constexpr ParticleMultigrid poisson_levels{3, true, {}};
/// In the plane: 16 particles a cell in place of 9, or the coarse levels would cost as much as the particles.
inline constexpr ParticleMultigrid plane_poisson_levels{4, true, {}};
constexpr const ParticleMultigrid& poisson_levels_in(int dimensions) { return dimensions == 2 ? plane_poisson_levels : poisson_levels; }

/// The sums over cells and the copies from them between particles and the first coarse level. Galerkin: A' = P^T A P, so what the particles
/// know of solids, free surface, prescribed neighbours and alpha is in it.
ConstraintPreconditionerSetup constraint_multigrid(const ParticleMultigrid& options = constraint_levels);
PressurePreconditionerSetup poisson_multigrid(const ParticleMultigrid& options = poisson_levels);

/// Unknowns from which on multigrid beats the diagonal, set-up included (docs/reports/pressure.md has the tables). In the constraint the
/// last step's pressures leave mostly errors that no coarse level resolves: a dam break of 49 000 particles is 10 % slower with it.
inline constexpr double constraint_multigrid_above = 500000, poisson_multigrid_above = 5000;
/// Whichever is faster for this many unknowns.
PressurePreconditioner constraint_automatic(const ConstraintMatrix& matrix);
PressurePreconditionerSetup poisson_automatic(const ParticleMultigrid& options = poisson_levels);

}  // namespace whorl

#pragma once
/// Multigrid preconditioners of the two pressure solves (docs/reports/pressure.md).
#include "engine/math/multigrid.h"
#include "engine/models/pressure/constraint.h"
#include "engine/models/pressure/poisson.h"

namespace whorl {

/// Size of the cells of the first coarse level, and the way in which the preconditioner combines particles and coarse levels.
struct ParticleMultigrid {
    Real cell;  ///< side of a cubic cell in spacings; the unknowns in a cell make one coarse unknown
    /// true: z = D^-1 r + P M P^T r with M the coarse levels. false: a V-cycle from the particles on, with the sweeps of `coarse`.
    bool additive = true;
    MultigridOptions coarse;
};

/// The side of a cell is an odd number of spacings. Pressures that are constant over an even number resemble the alternating modes that the
/// constraint's gradient does not see.
inline constexpr ParticleMultigrid constraint_levels{7, true, {}};
inline constexpr ParticleMultigrid poisson_levels{3, true, {}};
/// In 2D a cell has 16 particles instead of 9; otherwise the coarse levels would cost as much as the particles.
inline constexpr ParticleMultigrid plane_poisson_levels{4, true, {}};
constexpr const ParticleMultigrid& poisson_levels_in(int dimensions) { return dimensions == 2 ? plane_poisson_levels : poisson_levels; }

/// P copies from cells to particles, P^T sums over cells. The coarse matrix is Galerkin's, A' = P^T A P. So it includes solids, the free
/// surface, prescribed neighbours and the particles' alpha (pressure_matrix.h).
ConstraintPreconditionerSetup constraint_multigrid(const ParticleMultigrid& options = constraint_levels);
PressurePreconditionerSetup poisson_multigrid(const ParticleMultigrid& options = poisson_levels);

/// Number of unknowns above which multigrid is faster than the diagonal, set-up included (tables in docs/reports/pressure.md). The
/// constraint starts from the last step's pressures, whose errors are mostly too short for any coarse level: a dam break of 49 000
/// particles is 10 % slower with multigrid.
inline constexpr double constraint_multigrid_above = 500000, poisson_multigrid_above = 5000;
/// Choose the faster preconditioner for the number of unknowns.
PressurePreconditioner constraint_automatic(const ConstraintMatrix& matrix);
PressurePreconditionerSetup poisson_automatic(const ParticleMultigrid& options = poisson_levels);

}  // namespace whorl

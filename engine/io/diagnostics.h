#pragma once
/// diagnostics.csv: conserved and bounded quantities and costs, one row per frame.
#include <string>

#include "engine/simulation/energy_count.h"
#include "engine/simulation/simulation.h"

namespace whorl {

/// Sums over the particles that are out of the nozzles (role >= 0), in double, the same bits for any number of threads.
struct Measures : Energies {
    Index particles = 0;
    double max_speed = 0;                                  ///< m/s
    Vec3d momentum = Vec3d::Zero();                        ///< kg m/s
    Vec3d angular_momentum = Vec3d::Zero();                ///< kg m^2/s about the origin, sum m (x cross u + theta w)
    double density_error_mean = 0, density_error_max = 0;  ///< compression, max(0, rho/rho_0 - 1); 0 where no density is kept
    double volume = 0;                                     ///< coupled_volume() where it was found, else 0
};

/// Volume of the points outside solids that are within r of a particle, V(r), over that of the particles, n d^3 (in 2D n d^2): the
/// straight line through V(1.3 d) and V(2 d), read at 0.6 d (in 2D 0.55 d), where it has the true volume of a lattice with a flat
/// surface. So the roughness of the surface counts for little. Right within 1 % for a pool eight spacings deep; a cylinder of radius R has
/// about d^2/R^2 too little. In cells of half a spacing. 0 without particles and where they are strewn too widely.
/// @param x [m] @param spacing d [m]
double filled_volume(Span<const Vec3> x, const Domain& domain, const Solids& solids, Real spacing);
/// filled_volume() of all particles outside nozzles with the coupled solve, else 0.
double coupled_volume(const World& world);

/// @param gravity m/s^2 at the row's time @param micro_inertia theta, m^2 (1 where the scene's unit is dimensionless)
Measures measure(const World& world, const Vec3d& gravity, double micro_inertia);

/// The header line of diagnostics.csv. New columns go at the end.
std::string diagnostics_header();

/// One row, with the newline. Iterations are the mean a step between `before` (the totals at the last row) and `now`.
std::string diagnostics_row(int frame, double time, const Measures& measures, const RunTotals& before, const RunTotals& now, double wall,
                            double cpu);

std::string bodies_header();

/// @param gravity m/s^2 at the rows' time
std::string bodies_rows(int frame, double time, const World& world, const Vec3d& gravity);

}  // namespace whorl

#pragma once
/// diagnostics.csv: what is conserved, what is bounded, what it cost; a row a frame.
#include <string>

#include "engine/sim/energy_count.h"
#include "engine/sim/simulation.h"

namespace whorl {

/// Sums over the particles that are out of the nozzles (role >= 0), in double, the same bits for any number of threads.
struct Measures : Energies {
    Index particles = 0;
    double max_speed = 0;                                  ///< m/s
    Vec3d momentum = Vec3d::Zero();                        ///< kg m/s
    Vec3d angular_momentum = Vec3d::Zero();                ///< kg m^2/s about the origin, sum m (x cross u + theta w)
    double density_error_mean = 0, density_error_max = 0;  ///< compression, max(0, rho/rho_0 - 1); 0 where no density is kept
};

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

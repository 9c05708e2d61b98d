#pragma once
/// diagnostics.csv: conserved quantities, bounded quantities and costs, one row per frame.
#include <optional>
#include <string>

#include "engine/models/temperature/heat_options.h"
#include "engine/simulation/energy_count.h"
#include "engine/simulation/simulation.h"

namespace whorl {

/// Heat of the particles outside nozzles.
struct HeatMeasures {
    double total = 0;                           ///< enthalpy, 0 for solid material at 0 K [J]
    double mean = 0, coldest = 0, hottest = 0;  ///< temperature [K]
};
/// Empty if the particles carry no temperature.
std::optional<HeatMeasures> measure_heat(const World& world, const HeatLaw& law);

/// Sums over the particles outside nozzles (role >= 0), in double precision, bit-identical for any number of threads.
struct Measures : Energies {
    Index particles = 0;
    double max_speed = 0;                                  ///< m/s
    Vec3d momentum = Vec3d::Zero();                        ///< kg m/s
    Vec3d angular_momentum = Vec3d::Zero();                ///< kg m^2/s about the origin, sum m (x cross u + theta w)
    double density_error_mean = 0, density_error_max = 0;  ///< compression, max(0, rho/rho_0 - 1); 0 if the model has no density
    double volume = 0;                                     ///< coupled_volume() if it was computed, else 0
    std::optional<HeatMeasures> heat = {};                 ///< measure_heat() if it was computed
};

/// Estimates the fluid's volume divided by the volume n d^3 (2D: n d^2) of its n particles. V(r) is the volume of the points outside
/// solids that are within r of a particle. The estimate is the value at 0.6 d (2D: 0.55 d) of the straight line through V(1.3 d) and
/// V(2 d). For a lattice with a flat surface this is the true volume, and roughness of the surface matters little. The error is within 1 %
/// for a pool eight spacings deep; the result for a cylinder of radius R is too small by a fraction of about d^2/R^2. Volumes are computed
/// on cells of half a spacing. The result is 0 without particles, or if the particles are scattered too widely.
/// @param x positions [m] @param spacing d [m]
double filled_volume(Span<const Vec3> x, const Domain& domain, const Solids& solids, Real spacing);
/// filled_volume() of all particles outside nozzles if the coupled solve is used, else 0.
double coupled_volume(const World& world);

/// @param gravity at the row's time [m/s^2] @param micro_inertia theta [m^2] (1 if the scene is dimensionless)
Measures measure(const World& world, const Vec3d& gravity, double micro_inertia);

/// Header line of diagnostics.csv. New columns must go at the end. @param heat whether the rows have HeatMeasures
std::string diagnostics_header(bool heat = false);

/// One row with its newline. Iterations are means per step between `before` (the totals at the last row) and `now`.
std::string diagnostics_row(int frame, double time, const Measures& measures, const RunTotals& before, const RunTotals& now, double wall,
                            double cpu);

/// Header line of bodies.csv.
std::string bodies_header();

/// Rows of bodies.csv, one for each free body. @param gravity at the rows' time [m/s^2]
std::string bodies_rows(int frame, double time, const World& world, const Vec3d& gravity);

}  // namespace whorl

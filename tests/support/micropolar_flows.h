#pragma once
/// Micropolar flows with known answers, for the tests and for the tables of docs/reports/micropolar.md.
#include "engine/models/micropolar/micropolar.h"
#include "tests/support/world.h"

namespace whorl::test {

/// Density, gravity, these micropolar terms and kick, without motion. @param factor of the density next to walls
std::vector<Stage> micropolar_step_of(const MicropolarOptions& options, Real factor = 1);

/// The terms that one step of the stage Micropolar adds: the world's velocities and spins, pairs found and density set.
struct MicropolarStep {
    std::vector<Vec3> acceleration;  ///< m/s^2
    std::vector<Vec3> spin_change;   ///< 1/s
};
MicropolarStep micropolar_step(TestWorld& w, MicropolarOptions options);

/// curl u and curl w as the stage uses them, with the lattice's factor.
struct Curls {
    std::vector<Vec3> velocity, spin;
};
Curls curls_of(TestWorld& w, CurlForm velocity, CurlForm spin);

/// Kinematic coefficients: U' = -2 a k^2 U + kappa k W, theta W' = -2 g k^2 W + kappa (2 k U - 2 W) for u = U (sin kx cos ky, -cos kx sin
/// ky), w = W sin kx sin ky.
struct Micropolar2 {
    double a = 1, kappa = 1, g = 0.02, theta = 0.05;
};

/// Amplitudes after the time t from U = 1, W = 0: Runge-Kutta with steps of negligible error. @param k 1/m
std::pair<double, double> exact_vortex(const Micropolar2& c, double t, double k);

struct VortexError {
    double velocity = 0, spin = 0;  ///< largest difference of the amplitudes over the run, over their largest exact values
};
/// The flow on a lattice with N particles per wave, at fixed positions: the discrete operators against the system's own solution until the
/// velocity has fallen to about 1/e. Options: forms only; the coefficients are filled in. @param support over the spacing @param jitter of
/// the particles, in spacings
VortexError taylor_green_error(const Micropolar2& c, MicropolarOptions options, bool central, int N, double support = 2, double jitter = 0,
                               int dimensions = 3);

struct Drift {
    double momentum = 0;          ///< largest change over sum m |u|
    double angular_momentum = 0;  ///< largest change of orbital and spin together, over its value at the start
    double exchange = 0;  ///< | sum m u.(lambda curl w) - sum m w.(lambda curl u) |/rho over the larger: energy that the exchange adds or
                          ///< removes, at the start
};
/// A round blob with uneven particles and a free surface that turns faster inside, with spin, over `steps` steps of weakly compressible
/// flow.
Drift blob_drift(const Micropolar2& c, MicropolarOptions options, bool central, int steps, int dimensions = 3);

/// @param central use the second form of the Laplacian instead of the first; the caller sets "split"
MicropolarOptions with_coefficients(MicropolarOptions options, const Micropolar2& c, bool central);

}  // namespace whorl::test

/// Energy of a vortex that particle noise dissipates.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

constexpr double length = 0.1, nu = 2e-5;

/// Kinetic energy after `end` [s] over that at the start: an array of vortices at the Reynolds number 1000, 32 particles a wave.
/// @param depth of the slab [m]; 0: in 2D
double energy_left(const std::string& pressure_keys, double end, double depth = 0.0125) {
    const int dimensions = depth > 0 ? 3 : 2;
    const text::Point corner = text::point(dimensions, 0.1, 0.1, depth);
    const std::string periodic = depth > 0 ? "periodic = [true, true, true]\n" : "periodic = [true, true]\n";
    Simulation simulation =
        simulation_of(text::time(1) + text::domain(text::point(dimensions, 0, 0, 0), corner, periodic + "gravity = [0, 0, 0]") +
                      text::fluid(3.125e-3, 0.02, depth > 0 ? "" : "support = 3") + text::models("wcsph", "explicit") +
                      text::block(text::point(dimensions, 0, 0, 0), corner,
                                  "velocity = [\"0.2*sin(20*pi*x)*cos(20*pi*y)\", \"-0.2*cos(20*pi*x)*sin(20*pi*y)\", \"0\"]\n"
                                  "sampling = \"jittered\"") +
                      "[pressure]\nsound_speed = 2\nbackground_pressure = 100\nartificial_viscosity = 0\n" + pressure_keys);
    const double start = mean_square_speed(simulation);
    run_until(simulation, end);
    if (depth == 0)
        for (const Vec3& u : velocities(simulation)) REQUIRE(u.z() == 0);
    return mean_square_speed(simulation) / start;
}

}  // namespace

TEST_CASE("shifting keeps vortices at Reynolds 1000 within a tenth, the symmetric gradient loses half",
          "[validation][pressure][shifting][regression][long]") {
    // Disordered particles turn the energy that the symmetric gradient loses into noise, which viscosity dissipates: .45 are left of the
    // exact .88 after .4 s. With shifting .82 are; the jittered start costs a twentieth at the beginning.
    const double k = 2 * std::numbers::pi / length, end = 0.4, exact = std::exp(-4 * nu * k * k * end);
    const double even = energy_left("gradient = \"difference\"\n", end), symmetric = energy_left("", end);
    CAPTURE(exact, even, symmetric);
    CHECK(even == Approx(exact).epsilon(0.1));
    CHECK(symmetric < 0.6);
}

TEST_CASE("in 2D vortices at Reynolds 1000 keep their energy within a tenth over a turn", "[validation][pressure][shifting][plane]") {
    // Over 2 spacings a particle has 12 neighbours in 2D, and .79 of .88 are left; over 3 it has 28, as in 3D over 2.
    const double k = 2 * std::numbers::pi / length, end = 0.4, exact = std::exp(-4 * nu * k * k * end);
    CHECK(energy_left("gradient = \"difference\"\n", end, 0) == Approx(exact).epsilon(0.1));
}

/// Errors of the solver must not accumulate over short steps.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/benchmarks.h"
#include "tests/support/runs.h"

namespace short_steps_test {

using namespace whorl;
using namespace whorl::test;

namespace {

/// Rate at which scenes/studies/shear_wave.toml decays, 16 particles a wave, over nu k^2.
double decay_rate(const std::string& max_step) {
    const Scene scene = shipped_scene("studies/shear_wave", {"fluid.spacing=0.0625", "time.max_step=" + max_step});
    Simulation simulation(scene, make_plan(scene));
    const double start = mean_square_speed(simulation);
    run_until(simulation, scene.time.end);
    return std::log(start / mean_square_speed(simulation)) / (2 * 0.1 * 4 * std::numbers::pi * std::numbers::pi * scene.time.end);
}

}  // namespace

// A solve may leave an error of 1 % of the viscous change in a step. An implicit step of 1 ms is itself .2 % too weak.
TEST_CASE("the full viscosity damps a wave equally within 1.2 % in steps of 1 ms and .2 ms", "[validation][viscosity]") {
    const double coarse = decay_rate("1e-3"), fine = decay_rate("2e-4");
    INFO("rates over nu k^2: " << coarse << " and " << fine);
    CHECK(coarse == Approx(fine).margin(0.012));
    CHECK(fine == Approx(0.977).margin(0.012));  // error of the lattice's sums
}

}  // namespace short_steps_test

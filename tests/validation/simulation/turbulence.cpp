/// Turbulence in 2D against its equations for energy and enstrophy.
#include <catch2/catch.hpp>

#include "tests/support/benchmarks.h"
#include "tests/support/runs.h"
#include "tools/film/panel_scenes.h"

using namespace whorl;
using namespace whorl::test;

TEST_CASE("2D turbulence loses energy at 2 nu times its enstrophy, and its enstrophy never grows",
          "[validation][projection][plane][long]") {
    // scenes/turbulence.toml without spin and with four times the viscosity, so that the flow is well resolved. E is half of the mean
    // square of the velocity over the particles, Z half of the mean square of the vorticity. The probe's vorticity is by least squares over
    // two spacings, which smooths seven waves of 18 spacings: at the start, whose Z is known, it reads 4 % less.
    Options options;
    options.scene = WHORL_SOURCE_DIR "/scenes/turbulence.toml";
    options.set = {"fluid.viscosity=0.04"};
    const Scene scene = panel_scenes(read_scene_file(options)).at(0).scene;
    Simulation simulation(scene, make_plan(scene));
    const double nu = 0.04 / 1000, mass = 1000 * 0.125 * 0.125, dt = 0.02, end = 0.4;
    run_until(simulation, 0.02);  // a jittered start settles
    const auto now = [&] {
        const Table flow = reading(simulation, "flow");
        return std::pair{flow.at("kinetic_energy")[0] / mass, flow.at("mean_square_vorticity")[0] / 2};
    };
    const auto [first, first_enstrophy] = now();
    double lost = 0, enstrophy = first_enstrophy, energy = first;
    for (int k = 1; 0.02 + k * dt < end; ++k) {
        run_until(simulation, 0.02 + k * dt);
        const auto [E, Z] = now();
        lost += dt * nu * (enstrophy + Z);  // the trapezium of 2 nu Z
        CHECK(Z < 1.002 * enstrophy);
        energy = E, enstrophy = Z;
    }
    INFO("lost " << first - energy << " of " << first << ", by enstrophy " << lost);
    CHECK(first - energy > 0.3 * first);  // the loss is large enough to measure
    CHECK(first - energy == Approx(lost).epsilon(0.05));
}

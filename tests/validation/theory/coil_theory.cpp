#include "engine/theory/coil_theory.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace whorl;

// 34 settings, mostly in no table: from thick to thin, slow to fast, low to high, every third one of the grid. The solution changes
// smoothly with each of them along the branch, except at folds, when thin fluid falls far.
TEST_CASE("a steady coil is found for falls of 4 to 30 cm, 0.02 to 5 m^2/s and 5 to 50 cm/s", "[validation][coil]") {
    int most = 0, setting = 0;
    for (const double viscosity : {0.02, 0.05, 0.2, 1.0, 5.0})
        for (const double speed : {0.05, 0.1, 0.25, 0.5})
            for (const double fall : {0.04, 0.08, 0.15, 0.22, 0.3}) {
                if (setting++ % 3 != 0) continue;
                INFO(speed << " m/s from " << fall << " m, " << viscosity << " m^2/s");
                CoilSolver solver;
                const CoilParameters p{5e-3, speed, viscosity, 9.81, fall, 0};
                const auto theory = solver.at(p);
                REQUIRE(theory);
                most = std::max(most, solver.effort());
                // Laid at rest: the thread's speed is 2 pi f R, that of the rotating contact; the flux is that of the nozzle.
                CHECK(2 * M_PI * theory->frequency * theory->radius * std::pow(theory->thread_radius / 5e-3, 2) ==
                      Approx(speed).epsilon(1e-5));
                CHECK(theory->length > fall - theory->thread_radius);
                CHECK(theory->length < 2.2 * fall);
            }
    CHECK(most < CoilSolver::most_effort / 2);
}

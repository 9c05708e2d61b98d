/// pressure.source = "density", the published rows of the pressure equation, in fluid that moves.
#include <catch2/catch.hpp>

#include "engine/io/diagnostics.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace density_source_runs {

namespace {

const std::string published = text::pressure_form("projection") + "source = \"density\"\n";

}  // namespace

TEST_CASE("pressure.source density: a dam break gains no energy, loses no particle and comes to rest", "[validation][pressure][long]") {
    // The available potential energy of the dam is half of m g H. The energy may rise by 0.1 % when the wave falls on itself (0.003 % was
    // measured). The level: two fifths of the width are filled to H.
    constexpr double d = 0.0125, H = 12 * d;
    Simulation simulation = simulation_of(
        text::time(3, "max_step = 2e-3") + text::domain({-0.05, -0.05, 0}, {0.4, 0.5, 4 * d}, "periodic = [false, false, true]") +
        text::fluid(d) + published + text::block({0, 0, 0}, {10 * d, H, 4 * d}) + text::tank({0, 0, -1}, {25 * d, 0.45, 1}));
    const auto now = [&] { return measure(simulation.world(), Vec3d(0, -9.81, 0), 1); };
    const double falls = now().potential_energy;  // above the floor
    double least = 1e300, rise = 0;               // above the earlier minimum
    for (int k = 1; k <= 150; ++k) {
        run_until(simulation, 0.02 * k);
        const double energy = now().kinetic_energy + now().potential_energy;
        rise = std::max(rise, energy - least), least = std::min(least, energy);
    }
    const Measures end = now();
    CAPTURE(rise / falls, end.kinetic_energy / falls, end.potential_energy / falls);
    CHECK(rise < 0.001 * falls);
    CHECK(end.kinetic_energy < 0.01 * falls);
    CHECK(end.potential_energy == Approx(0.4 * falls).epsilon(0.05));
    CHECK(simulation.totals().lost_particles == 0);
}

TEST_CASE("pressure.source density: a lone falling particle rests half a spacing above the floor", "[validation][pressure]") {
    // It approaches by a tenth of the remaining distance per step, and comes to rest at most g dt^2/share = .01 d off because of its
    // weight.
    for (const int dimensions : {2, 3}) {
        const auto at = [&](double x, double y, double z) { return text::point(dimensions, x, y, z); };
        Simulation simulation =
            simulation_of(text::time(0.8) + text::domain(at(-0.1, -0.05, -0.1), at(0.1, 0.2, 0.0104)) + text::fluid(0.01) + published +
                          text::block(at(0, 0.05, 0), at(0.0104, 0.0604, 0.0104)) + text::plane(at(0, 0, 0), at(0, 1, 0)));
        double lowest = 1;
        for (int k = 1; k <= 40; ++k) {
            run_until(simulation, 0.02 * k);
            lowest = std::min<double>(lowest, positions(simulation)[0].y());
        }
        CHECK(lowest > 0.0049);
        CHECK(positions(simulation)[0].y() == Approx(0.005).epsilon(0.02));
    }
}

}  // namespace density_source_runs

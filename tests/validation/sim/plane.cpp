/// Flows of two dimensions: read, plan, simulate.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace plane_test {

namespace {

constexpr double g = 9.81, rho_0 = 1000, height = 0.15;

/// Water at rest in a box of two dimensions, 12 by 30 particles.
struct Rest {
    double weight;   ///< difference of pressure between the lowest and the middle third over the weight between them
    double fastest;  ///< over sqrt(2 g H), in the last fifth of a second
};
Rest at_rest(const std::string& model) {
    Simulation simulation =
        simulation_of(text::time(1, "max_step = 2e-3") + text::domain({-0.05, -0.05}, {0.11, 0.2}) + text::fluid(0.005) +
                      text::block({0, 0}, {0.06, height}) + text::tank({0, 0}, {0.06, 0.2}) + text::models(model));
    run_until(simulation, 0.6);
    double difference = 0, exact = 0, fastest = 0;
    for (int frame = 1; frame <= 60; ++frame) {  // pressures are known at frame times; three equal steps
        run_until(simulation, 0.6 + 0.006 * frame);
        const auto x = simulation.world().fluid.column<field::position>();
        const auto p = simulation.world().fluid.column<field::pressure>();
        const auto u = simulation.world().fluid.column<field::velocity>();
        double pressure[2] = {0, 0}, middle[2] = {0, 0};
        int count[2] = {0, 0};
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (frame > 26) fastest = std::max(fastest, static_cast<double>(u[i].norm()));
            if (x[i].y() > 0.1) continue;
            const int upper = x[i].y() > 0.05;
            pressure[upper] += p[i], middle[upper] += x[i].y(), ++count[upper];
        }
        difference += pressure[0] / count[0] - pressure[1] / count[1];
        exact += rho_0 * g * (middle[1] / count[1] - middle[0] / count[0]);
    }
    CHECK(simulation.totals().lost_particles == 0);
    return {difference / exact, fastest / std::sqrt(2 * g * height)};
}

}  // namespace

TEST_CASE("in the plane water comes to rest in a box with the pressure of its weight within 2 %", "[validation][sim][plane]") {
    for (const std::string model : {"ppe", "wcsph"}) {
        const Rest rest = at_rest(model);
        CAPTURE(model, rest.weight, rest.fastest);
        CHECK(rest.weight == Approx(1).epsilon(0.02));
        CHECK(rest.fastest < 0.02);
    }
}

}  // namespace plane_test

/// Free bodies under the projection, compared with Archimedes and added masses.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace projection_bodies_test {

namespace {

/// A disc of five spacings in the middle of a round vessel full of water, three times as wide.
std::string vessel(double density, double max_step = 2e-3, const std::string& gravity = "", double viscosity = 0) {
    return text::time(3, fmt::format("max_step = {}", max_step)) + text::domain({-0.2, -0.2}, {0.2, 0.2}, gravity) +
           text::fluid(0.01, viscosity) + text::drop({0, 0}, 0.15) + text::ball({0, 0}, 0.15, "container = true") +
           text::ball({0, 0}, 0.05, fmt::format("density = {}", density));
}
const std::string projection = "[pressure]\nform = \"projection\"\n";

/// Checks the acceleration from rest up to `time`, (m_f - m) g/(m + C m_f), and that nothing pushes the body aside.
void starts(const std::string& scene, double density, double C, double time, double tolerance) {
    INFO("density " << density);
    Simulation simulation = simulation_of(projection + scene);
    run_until(simulation, time);
    const Vec3d v = last_body(simulation).velocity;
    CHECK(v.y() / time == Approx((1000 - density) / (density + 1000 * C) * 9.81).epsilon(tolerance));
    CHECK(std::hypot(v.x(), v.z()) < 0.01 * std::abs(v.y()));
}

}  // namespace

TEST_CASE("under the projection a disc starts with (m_f - m) g/(m + C m_f) within 14 % at R = 5 d", "[validation][projection][bodies]") {
    // The pressure is read half a spacing off the surface: the added mass comes out too small, by 12 % of the acceleration for a light disc
    // and by 3 % for a disc twice as dense as the fluid. C = (b^2 + a^2)/(b^2 - a^2) in a vessel of radius b about a disc of radius a.
    for (const double density : {10.0, 100.0, 2000.0, 8000.0}) starts(vessel(density), density, 1.25, 0.02, 0.14);
}

TEST_CASE("under the projection a ball starts with (m_f - m) g/(m + C m_f) within 10 % at R = 4 d", "[validation][projection][bodies]") {
    // C = (b^3 + 2 a^3)/(b^3 - a^3)/2 in a vessel of radius b = 2.5 a about a ball of radius a. Too fast by 3 % if it is twice as dense as
    // the fluid, and by 8 % if it has a tenth of that density: the pressure is read half a spacing off the surface.
    for (const double density : {100.0, 500.0, 2000.0})
        starts(text::time(1, "max_step = 2e-3") + text::domain({-0.15, -0.15, -0.15}, {0.15, 0.15, 0.15}) + text::fluid(0.01, 0.5) +
                   text::drop({0, 0, 0}, 0.1) + text::ball({0, 0, 0}, 0.1, "container = true") +
                   text::ball({0, 0, 0}, 0.04, fmt::format("density = {}", density)),
               density, 0.6026, 0.01, 0.1);
}

TEST_CASE("under the projection a disc of the fluid's density stays where it is", "[validation][projection][bodies]") {
    // The vessel's lattice melts meanwhile: what its particles do to a disc five of them in radius is 1 % of its weight.
    Simulation simulation = simulation_of(projection + vessel(1000));
    for (const double time : {0.1, 0.2, 0.3}) {
        run_until(simulation, time);
        CHECK(last_body(simulation).velocity.norm() < 0.02 * 9.81 * time);
    }
    CHECK(simulation.totals().lost_particles == 0);
}

TEST_CASE("under the projection a raft half as dense as water floats half under water, within .4 spacings",
          "[validation][projection][bodies][long]") {
    // The pressure is 0 at the outermost particles, half a spacing below the surface, so it may float that much deeper.
    constexpr double d = 0.025;
    Simulation simulation =
        simulation_of(text::time(9, "max_step = 1e-2") + text::domain({-0.1, -0.1}, {1.1, 1.1}) + text::fluid(d, 1) + projection +
                      text::block({0, 0}, {1, 0.5}) + text::tank({0, 0}, {1, 1}) + text::box({0.35, 0.4}, {0.65, 0.6}, "density = 500"));
    double mean = 0;
    int rows = 0;
    for (run_until(simulation, 2); simulation.time() < 3; ++rows)
        run_until(simulation, simulation.time() + 0.1), mean += last_body(simulation).centre.y();
    CHECK(mean / rows == Approx(0.5).margin(0.4 * d));
    CHECK((last_body(simulation).turn * Vec3d::UnitY()).y() > 0.999);
    CHECK(simulation.totals().lost_particles == 0);
}

TEST_CASE("under the projection a heavy disc loses its spin as in circular Couette flow, within 5 %", "[validation][projection][bodies]") {
    // Torque 4 pi mu w a^2 b^2/(b^2 - a^2), inertia m a^2/2: a rate of .3600/s once the flow has become steady, with
    // five spacings in the radius.
    Simulation simulation =
        simulation_of(projection + text::models("", "explicit") + vessel(1e5, 5e-3, "gravity = [0, 0]", 10) + "rotation = [0, 0, 1]\n");
    run_until(simulation, 0.5);  // five times (b - a)^2/(pi^2 nu)
    const double before = last_body(simulation).spin_momentum.z();
    run_until(simulation, 0.8);
    CHECK(std::log(before / last_body(simulation).spin_momentum.z()) / 0.3 == Approx(0.36).epsilon(0.05));
}

}  // namespace projection_bodies_test

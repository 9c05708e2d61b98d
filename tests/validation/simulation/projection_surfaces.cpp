/// Surface tension under the projection, against linear theory: the pressure in a drop, its oscillation, and capillary-gravity waves.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/benchmarks.h"
#include "tests/support/runs.h"
#include "tests/support/zeros.h"

using namespace whorl;
using namespace whorl::test;

namespace projection_surfaces_test {

namespace {

constexpr double pi = std::numbers::pi, sigma = 0.072, rho = 1000;

const std::vector<std::string> in_space{"domain.dimensions=3",    "domain.min=[-0.01,-0.01,-0.01]", "domain.max=[0.01,0.01,0.01]",
                                        "domain.gravity=[0,0,0]", "probe.0.min=[0,0,-0.01]",        "probe.0.max=[0.01,0.01,0.01]",
                                        "probe.1.at=[0,0,0]"};

std::vector<std::string> with(std::vector<std::string> changes, bool space) {
    if (space) changes.insert(changes.end(), in_space.begin(), in_space.end());
    return changes;
}

/// Radius of a disc or ball of the fluid's volume [m].
double radius_of(const Simulation& simulation) {
    const StepContext& step = simulation.world().step;
    const double volume = static_cast<double>(step.volume) * static_cast<double>(simulation.world().fluid.size());
    return step.dimensions() == 2 ? std::sqrt(volume / pi) : std::cbrt(3 * volume / (4 * pi));
}

/// Checks the mean pressure within half the radius and the root mean square speed over sqrt(sigma/(rho R)), after 0.1 s.
void rests(bool space, const char* spacing) {
    Simulation simulation =
        benchmark("swinging_drop", with({space ? "block.0.velocity=[0,0,0]" : "block.0.velocity=[0,0]", spacing}, space));
    run_until(simulation, 0.1);
    const auto x = positions(simulation);
    const auto p = pressures(simulation);
    const double R = radius_of(simulation);
    double sum = 0;
    int inside = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        if (static_cast<double>(x[i].norm()) < R / 2) sum += static_cast<double>(p[i]), ++inside;
    CHECK(sum / inside * R / ((space ? 2 : 1) * sigma) == Approx(1).epsilon(0.02));
    CHECK(std::sqrt(mean_square_speed(simulation) * rho * R / sigma) < 0.02);
}

/// Checks the period of the second mode, and the fraction of its amplitude that remains after a period.
void swings(bool space, const char* spacing, double kept) {
    std::vector<std::string> changes{spacing};
    if (space) changes.push_back("block.0.velocity=[\"1.5*x\",\"1.5*y\",\"-3*z\"]");
    Simulation simulation = benchmark("swinging_drop", with(changes, space));
    const double R = radius_of(simulation), omega = std::sqrt((space ? 8 : 6) * sigma / (rho * R * R * R));
    const auto mode = [&](const Vec3d& x, const Vec3d&) {
        return space ? x.x() * x.x() + x.y() * x.y() - 2 * x.z() * x.z() : x.x() * x.x() - x.y() * x.y();
    };
    const Oscillation found = oscillation(simulation, 5, pi / omega / 3, 0.33, [&] { return mean_of(simulation, mode); });
    CHECK(found.period == Approx(2 * pi / omega).epsilon(0.05));
    CHECK(std::sqrt(found.crests[4] / found.crests[0]) > kept);
}

}  // namespace

TEST_CASE("under the projection a 2D drop has the pressure sigma/R within 2 %, theory's period within 5 %",
          "[validation][projection][tension]") {
    rests(false, "fluid.spacing=4e-4");
    swings(false, "fluid.spacing=4e-4", 0.85);
}

TEST_CASE("under the projection a 3D drop has the pressure 2 sigma/R within 2 %, theory's period within 5 %",
          "[validation][projection][tension][long]") {
    rests(true, "fluid.spacing=6e-4");
    swings(true, "fluid.spacing=5e-4", 0.75);
}

TEST_CASE("capillary-gravity waves under the projection keep the period of theory within 5 %", "[validation][projection][tension][long]") {
    // omega^2 = (g k + sigma k^3/rho) tanh kh: with 40 N/m half of it is surface tension's.
    constexpr double k = 2 * pi / 0.4, tension = 40;
    const double period = 2 * pi / std::sqrt((9.81 * k + tension * k * k * k / rho) * std::tanh(k * 0.2));
    Simulation simulation = benchmark("standing_wave", {"fluid.surface_tension=40"});
    const Oscillation found = oscillation(simulation, 7, period / 4, 2.8, [&] { return vertical_wave(simulation, k); });
    CHECK(found.period == Approx(period).epsilon(0.05));
}

}  // namespace projection_surfaces_test

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

/// Mean pressure within half the radius over (D - 1) sigma/R, and the mean square speed over sqrt(sigma/(rho R)), after 0.1 s.
struct Rest {
    double pressure = 0, speed = 0;
};
Rest drop_at_rest(bool space, const char* spacing) {
    Simulation simulation =
        benchmark("swinging_drop", with({space ? "block.0.velocity=[0,0,0]" : "block.0.velocity=[0,0]", spacing}, space));
    run_until(simulation, 0.1);
    const auto x = simulation.world().fluid.column<field::position>();
    const auto u = simulation.world().fluid.column<field::velocity>();
    const auto p = simulation.world().fluid.column<field::pressure>();
    const double R = radius_of(simulation);
    double sum = 0, square = 0;
    int inside = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        square += u[i].cast<double>().squaredNorm() / static_cast<double>(x.size());
        if (static_cast<double>(x[i].norm()) < R / 2) sum += static_cast<double>(p[i]), ++inside;
    }
    return {sum / inside * R / ((space ? 2 : 1) * sigma), std::sqrt(square * rho * R / sigma)};
}

/// The second mode: its period over theory, and the fraction of the amplitude that remains after a period.
struct Swing {
    double period = 0, kept = 0;
};
Swing swing(bool space, const char* spacing) {
    std::vector<std::string> changes{spacing};
    if (space) changes.push_back("block.0.velocity=[\"1.5*x\",\"1.5*y\",\"-3*z\"]");
    Simulation simulation = benchmark("swinging_drop", with(changes, space));
    const double R = radius_of(simulation), omega = std::sqrt((space ? 8 : 6) * sigma / (rho * R * R * R));
    Zeros zeros(pi / omega / 3);
    std::vector<double> crests{0};  // largest |signal| between zeros
    while (zeros.at.size() < 5) {
        REQUIRE(simulation.time() < 0.33);
        REQUIRE_FALSE(simulation.step(0.33).diverged);
        const auto x = simulation.world().fluid.column<field::position>();
        double now = 0;
        for (const Vec3& at : x)
            now += static_cast<double>(space ? at.x() * at.x() + at.y() * at.y() - 2 * at.z() * at.z() : at.x() * at.x() - at.y() * at.y());
        const std::size_t before = zeros.at.size();
        zeros.sample(simulation.time(), now);
        if (zeros.at.size() > before) crests.push_back(0);
        crests.back() = std::max(crests.back(), std::abs(now));
    }
    return {(zeros.at[4] - zeros.at[0]) / 2 * omega / (2 * pi), std::sqrt(crests[4] / crests[0])};
}

}  // namespace

TEST_CASE("under the projection a 2D drop rests with the pressure sigma/R within 2 %", "[validation][projection][tension]") {
    const Rest rest = drop_at_rest(false, "fluid.spacing=4e-4");
    CHECK(rest.pressure == Approx(1).epsilon(0.02));
    CHECK(rest.speed < 0.02);
}

TEST_CASE("under the projection a 3D drop rests with the pressure 2 sigma/R within 2 %", "[validation][projection][tension][long]") {
    const Rest rest = drop_at_rest(true, "fluid.spacing=6e-4");
    CHECK(rest.pressure == Approx(1).epsilon(0.02));
    CHECK(rest.speed < 0.02);
}

TEST_CASE("under the projection a 2D drop oscillates with the period of theory within 5 %", "[validation][projection][tension]") {
    const Swing of = swing(false, "fluid.spacing=4e-4");
    CHECK(of.period == Approx(1).epsilon(0.05));
    CHECK(of.kept > 0.85);
}

TEST_CASE("under the projection a 3D drop oscillates with the period of theory within 5 %", "[validation][projection][tension][long]") {
    const Swing of = swing(true, "fluid.spacing=5e-4");
    CHECK(of.period == Approx(1).epsilon(0.05));
    CHECK(of.kept > 0.75);
}

TEST_CASE("capillary-gravity waves under the projection keep the period of theory within 5 %", "[validation][projection][tension][long]") {
    // omega^2 = (g k + sigma k^3/rho) tanh kh: with 40 N/m half of it is surface tension's.
    constexpr double k = 2 * pi / 0.4, tension = 40;
    const double period = 2 * pi / std::sqrt((9.81 * k + tension * k * k * k / rho) * std::tanh(k * 0.2));
    Simulation simulation = benchmark("standing_wave", {"fluid.surface_tension=40"});
    Zeros zeros(period / 4);
    while (zeros.at.size() < 7) {
        REQUIRE(simulation.time() < 2.8);
        REQUIRE_FALSE(simulation.step(2.8).diverged);
        const auto x = simulation.world().fluid.column<field::position>();
        const auto u = simulation.world().fluid.column<field::velocity>();
        double now = 0;
        for (std::size_t i = 0; i < x.size(); ++i) now += static_cast<double>(u[i].y()) * std::cos(k * static_cast<double>(x[i].x()));
        zeros.sample(simulation.time(), now);
    }
    CHECK((zeros.at[6] - zeros.at[0]) / 3 == Approx(period).epsilon(0.05));
}

}  // namespace projection_surfaces_test

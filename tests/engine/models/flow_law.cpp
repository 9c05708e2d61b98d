/// Yield stress, consistency and flow index: the law, and the scenes that it fits.
#include "engine/models/viscosity/flow_law.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/poured_honey.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

/// A free square of fluid that shears and stretches, without weight.
std::string free_square(const std::string& pressure, const std::string& law, double step = 5e-3) {
    return text::time(1, fmt::format("max_step = {}", step)) + text::domain({-0.2, -0.2}, {0.2, 0.2}, "gravity = [0, 0]") +
           text::fluid(0.01, 0, law) + text::models(pressure, pressure == "coupled" ? "" : "full") +
           text::block({-0.05, -0.05}, {0.05, 0.05}, "velocity = [\"0.3 + 4*x + 10*y\", \"0.1 - 4*y\"]");
}
const std::string bingham = "yield_stress = 30\nviscosity = 3\n";

}  // namespace

TEST_CASE("the apparent viscosity is that of Herschel and Bulkley within 1 % from 5 g_0 on, and finite at rest", "[viscosity][yield]") {
    for (const double n : {0.4, 1.0, 1.3}) {
        const FlowLaw law{50, n};
        const double K = 5, g0 = std::min(1e-3, 1e-4 * std::pow(50 / K, 1 / n));
        for (double gamma = 5 * g0; gamma < 1e3; gamma *= 3) {
            CAPTURE(n, gamma);
            CHECK(gamma * law.apparent_viscosity(K, gamma) == Approx(50 + K * std::pow(gamma, n)).epsilon(0.01));
            const double slope = (1.001 * law.apparent_viscosity(K, 1.001 * gamma) - law.apparent_viscosity(K, gamma)) / 1e-3;
            CHECK(law.tangent_viscosity(K, gamma) == Approx(slope).epsilon(0.01));
        }
        CHECK(law.apparent_viscosity(K, 0) == Approx(50 / g0 + K * std::pow(g0, n - 1)));
    }
    CHECK_FALSE(FlowLaw{}.acts());
}

// 30 Pa: the body flows throughout. 3000 Pa: tau_y/(rho L) = 30 m/s^2 stops its strain of 0.5 m/s within 0.02 s. 30000 Pa: within a few
// steps. 1e-6 of the energy is the rounding of single precision. Steps of 1 ms where the body turns rigidly: there the integration in time
// errs by a share of (angle per step)^2 until the stress is steady, 2e-6 with 5 ms. The shifts of `coupled` displace fluid without changing
// its velocity, which changes the angular momentum while it flows.
TEST_CASE("a body that stiffens loses energy in every step, keeps its momenta, and becomes rigid", "[sim][yield]") {
    const auto [pressure, turning] = GENERATE(table<std::string, double>({{"ppe", 1e-5}, {"coupled", 3e-3}}));
    const double stress = GENERATE(30, 300, 3000, 30000), step = pressure == "coupled" && stress >= 3000 ? 1e-3 : 5e-3;
    Simulation s = simulation_of(free_square(pressure, fmt::format("yield_stress = {}\nviscosity = 3\n", stress), step));
    const auto momentum = [&] { return mean_of(s, [](const Vec3d&, const Vec3d& u) { return u.x() + 2 * u.y(); }); };
    const auto spin = [&] { return mean_of(s, [](const Vec3d& x, const Vec3d& u) { return x.cross(u).z(); }); };
    const double momentum_before = momentum(), spin_before = spin();
    double energy = mean_square_speed(s);
    while (s.time() < 0.03) {
        REQUIRE_FALSE(s.step(1).diverged);
        CAPTURE(pressure, stress, s.time());
        CHECK(mean_square_speed(s) < energy * (1 + 1e-6));
        energy = mean_square_speed(s);
    }
    CHECK(momentum() == Approx(momentum_before).epsilon(1e-5));
    CHECK(spin() == Approx(spin_before).epsilon(turning));
    double fastest = 0;  // 10 1/s at the start
    for (const Real gamma : s.world().fluid.column<field::shear_rate>()) fastest = std::max(fastest, static_cast<double>(gamma));
    if (stress >= 3000) CHECK(fastest < 0.3);
}

TEST_CASE("a run with a yield stress resumes bit-identically", "[sim][yield][resume]") {
    CHECK(differing_bits(free_square("ppe", bingham), 0.02) == "");
    CHECK(differing_bits(free_square("coupled", "yield_stress = 30\nconsistency = 30\nflow_index = 0.6\n"), 0.02) == "");
}

TEST_CASE("only fluid with a yield stress or flow index has a shear rate, and a yield stress of 0 changes no bit", "[sim][yield]") {
    for (const char* pressure : {"ppe", "coupled"}) {
        Simulation plain = simulation_of(free_square(pressure, "viscosity = 3\n")),
                   none = simulation_of(free_square(pressure, "yield_stress = 0\nconsistency = 3\n"));
        for (Simulation* s : {&plain, &none}) REQUIRE_FALSE(s->step(1).diverged);
        const auto bits = [](const Simulation& s) {
            const auto u = s.world().fluid.column<field::velocity>();
            return std::vector<Vec3>(u.begin(), u.end());
        };
        CHECK(bits(plain) == bits(none));
        CHECK_FALSE(plain.world().fluid.has<field::shear_rate>());
        CHECK(simulation_of(free_square(pressure, bingham)).world().fluid.has<field::shear_rate>());
    }
}

TEST_CASE("a yield stress is refused with other viscosities, spin, or without a viscosity, and the fix is named", "[plan][yield]") {
    const auto message_of = [](const std::string& law, const std::string& models) {
        return messages_with({}, text::time(1) + text::domain({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}) + text::fluid(0.02, 0, law) +
                                     "[models]\n" + models + "\n" + text::block({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}));
    };
    const std::string ppe = "pressure = \"ppe\"\n";
    for (const std::string other : {"explicit", "xsph", "none", "full_assembled"})
        CHECK_THAT(message_of(bingham, ppe + "viscosity = \"" + other + "\""),
                   Catch::Contains("fluid.yield_stress makes the viscosity depend on the strain rate, which models.viscosity = \"" + other +
                                   "\" does not support; use models.viscosity = \"full\" with viscosity.correction = true, or "
                                   "models.pressure = \"coupled\""));
    CHECK_THAT(message_of(bingham, ppe + "viscosity = \"full\"\n[viscosity]\ncorrection = false"), Catch::Contains("does not support"));
    CHECK_THAT(message_of(bingham, "micropolar = \"bender\""), Catch::Contains("micropolar fluids have one viscosity"));
    CHECK_THAT(message_of("yield_stress = 30\n", ""), Catch::Contains("set fluid.viscosity, the plastic viscosity of a Bingham fluid"));
    CHECK_THAT(message_of("viscosity = 3\nflow_index = 0.5\n", ""), Catch::Contains("fluid.flow_index = 0.5 needs a consistency"));
    CHECK_THAT(message_of("viscosity = 3\nconsistency = 2\n", ""), Catch::Contains("both give K; remove fluid.viscosity"));
    CHECK(message_of(bingham, "") == "no error");
    CHECK(message_of("yield_stress = 30\nconsistency = 2\nflow_index = 0.5\n", ppe + "[pressure]\nform = \"projection\"") == "no error");
}

TEST_CASE("fluid with a yield stress has the coupled pressure however thin it flows", "[plan][yield]") {
    // Ketchup that falls by .3 m: nu dt/d^2 is 0.03 at a shear rate of speed over spacing.
    const std::string ketchup = text::time(1) + text::domain({-0.2, 0}, {0.6, 0.6}) +
                                text::fluid(5e-3, 0, "density = 1150\nyield_stress = 30\nconsistency = 5\nflow_index = 0.3") +
                                text::block({0, 0.3}, {0.1, 0.4}) + text::plane({0, 0}, {0, 1});
    CHECK(make_plan(scene_with({}, ketchup)).pressure == PressureModel::coupled);
    CHECK(messages_with({}, ketchup + text::models("coupled")) == "no error");
}

TEST_CASE("models that lock fluid near its yield stress refuse one under weight", "[plan][yield]") {
    const auto message_of = [](const std::string& models, const std::string& gravity, const std::string& more = "") {
        return messages_with({}, text::time(1) + text::domain({0, 0}, {0.4, 0.4}, gravity) + text::fluid(0.02, 0, bingham) + models +
                                     text::block({0.1, 0}, {0.3, 0.2}) + text::plane({0, 0}, {0, 1}) + more);
    };
    const std::string body = text::ball({0.2, 0.1}, 0.05, "density = 2000"),
                      locks =
                          " fluid under its weight locks and slips like sand: at 1.1 times its yield stress it flows at 0.2 to 1.4 "
                          "times its speed, and heaps stay a sixth too high; use models.pressure = ";
    const std::string full = text::models("ppe", "full");
    CHECK_THAT(message_of(full, ""), Catch::Contains("with pressure.form = \"constraint\"" + locks + "\"coupled\""));
    CHECK_THAT(message_of(text::models("wcsph", "full"), ""), Catch::Contains("with models.pressure = \"wcsph\"" + locks + "\"coupled\""));
    CHECK_THAT(message_of(full + "[pressure]\nform = \"projection\"\nsource = \"density\"\n", ""),
               Catch::Contains("with pressure.source = \"density\"" + locks + "\"coupled\""));
    CHECK(message_of("", "", body) == "no error");
    CHECK(message_of(full + "[pressure]\nform = \"projection\"\n", "", body) == "no error");
    CHECK(message_of(full, "gravity = [0, 0]") == "no error");
}

TEST_CASE("a block of 800 Pa on a molten layer of 0.5 Pa s solves within 200 iterations", "[sim][yield]") {
    Simulation s = simulation_of(text::time(1) + text::domain({-0.02, 0, -0.02}, {0.02, 0.03, 0.02}) +
                                 text::fluid(2.5e-3, 0,
                                             "density = 900\nviscosity = \"temperature < 306 ? 200 : 0.5\"\n"
                                             "yield_stress = \"temperature < 306 ? 800 : 0\"") +
                                 text::block({-0.01, 0, -0.01}, {0.01, 0.015, 0.01}, "temperature = \"y < 0.006 ? 310 : 280\"") +
                                 text::plane({0, 0, 0}, {0, 1, 0}));
    while (s.time() < 0.02)
        for (const auto& solve : s.step(1).solves) CHECK(solve.report.converged);
}

// Closed vortex lines that the fluid has at the start.
#include "engine/simulation/vortex_loops.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/errors.h"
#include "engine/models/ink/ink.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

VortexKeys ring(double radius, double core) {
    VortexKeys keys;
    keys.path = {{Expression(0.0), Expression(fmt::format("{}*cos(t)", radius)), Expression(fmt::format("{}*sin(t)", radius))}};
    keys.circulation = 2, keys.core = core;
    return keys;
}

Domain open_space() { return {Vec3::Constant(-5), Vec3::Constant(5), {false, false, false}}; }

std::string fluid_with(const std::string& vortex, const std::string& domain = "periodic = [true, true, true]") {
    return text::time(1, "fps = 4") + text::domain({-1, -1, -1}, {1, 1, 1}, "gravity = [0, 0, 0]\n" + domain) + text::fluid(0.1) +
           text::block({-1, -1, -1}, {1, 1, 1}, "velocity = [\"0.1\", \"0\", \"0\"]") + "[[vortex]]\n" + vortex;
}

const std::string round_line = "path = [\"0\", \"0.5*cos(t)\", \"0.5*sin(t)\"]\ncirculation = 0.5\n";

}  // namespace

// Exact on the axis: Gamma R^2/(2 (R^2 + x^2 + a^2)^(3/2)). The ring is a polygon of 88 sides, whose area is 9e-4 too small.
TEST_CASE("a vortex ring's velocity on its axis is that of Biot and Savart within .1 %", "[sim][vortex]") {
    const double R = 0.7, a = 0.2;
    const VortexLoop loop(ring(R, a), open_space());
    for (const double x : {-0.9, 0.0, 0.3, 2.0}) {
        const Vec3d u = loop.velocity({x, 0, 0});
        CHECK(u.x() == Approx(2 * R * R / (2 * std::pow(R * R + x * x + a * a, 1.5))).epsilon(1e-3));
        CHECK(std::hypot(u.y(), u.z()) < 1e-12);
    }
}

// Gamma/(4 pi R) (ln(8R/a) - 1) for a thin core (Saffman, Vortex Dynamics, 1992, section 11.2, for the core of Rosenhead and Moore), to
// second order in a/R = .02.
TEST_CASE("a vortex ring moves itself with the speed of a thin ring within 1 %", "[sim][vortex]") {
    const double R = 1, a = 0.02;
    const Vec3d u = VortexLoop(ring(R, a), open_space()).velocity({0, R, 0});
    CHECK(u.x() == Approx(2 / (4 * M_PI * R) * (std::log(8 * R / a) - 1)).epsilon(0.01));
}

TEST_CASE("a vortex adds its velocity to the block's, and its ink fills the core", "[sim][vortex][ink]") {
    const Simulation simulation = simulation_of(fluid_with(round_line + "core = 0.2\nink = [\"0\", \"t < 3.1416 ? 1 : 0.5\"]"));
    const World& world = simulation.world();
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const auto ink = world.fluid.column<field::ink>();
    VortexKeys keys = ring(0.5, 0.2);
    keys.circulation = 0.5;
    const VortexLoop loop(keys, world.step.domain);
    int inside = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3d expected = Vec3d(0.1, 0, 0) + loop.velocity(x[i].cast<double>());
        CHECK((u[i].cast<double>() - expected).norm() < 1e-6);
        const double r = std::hypot(x[i].x(), std::hypot(x[i].y(), x[i].z()) - 0.5), most = x[i].z() > 0 ? 1 : 0.5;
        CHECK(ink[i].x() == 0);
        CHECK(ink[i].y() == Approx(most * std::exp(-std::pow(r / 0.2, 4))).margin(0.01));  // the ring is a polygon
        inside += r < 0.15;
    }
    CHECK(inside > 100);
}

TEST_CASE("an impossible vortex is refused with the reason", "[sim][vortex]") {
    const auto refused = [](const std::string& scene, const std::string& why) {
        CHECK_THROWS_WITH(simulation_of(scene), Catch::Contains(why));
    };
    refused(fluid_with(round_line + "core = 0.05"), "less than a spacing");
    refused(fluid_with("path = [\"0\", \"0.5*cos(t/2)\", \"0\"]\ncirculation = 1\ncore = 0.2"), "is not closed");
    refused(fluid_with("path = [\"0\", \"1.5*cos(t)\", \"1.5*sin(t)\"]\ncirculation = 1\ncore = 0.2", "periodic = [false, false, false]"),
            "leaves the domain");
    refused(fluid_with("path = [\"0\", \"cos(t)/sin(t)*0\", \"1/0*t\"]\ncirculation = 1\ncore = 0.2"), "path is not finite");
}

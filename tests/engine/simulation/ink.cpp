// Ink in whole scenes.
#include "engine/models/ink/ink.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/errors.h"
#include "engine/io/snapshot.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace ink_scene_test {

namespace {

const std::string of_stream_function = "ink = [\"0.5+0.5*sin(2*pi*x)*sin(2*pi*y)\", 0.25]";

/// Vortices that turn in a periodic square of 1 m; the ink is a function of their stream function, which is constant along the flow.
std::string vortices(const std::string& fluid, const std::string& more, const std::string& ink = of_stream_function) {
    return text::time(2, "fps = 2") + text::domain({0, 0}, {1, 1}, "periodic = [true, true]\ngravity = [0, 0]") +
           text::fluid(0.03125, 0, fluid) + text::pressure_form("projection") +
           text::block({0, 0}, {1, 1}, "velocity = [\"sin(2*pi*x)*cos(2*pi*y)\", \"-cos(2*pi*x)*sin(2*pi*y)\"]\n" + ink) + more;
}

const std::string stream = "[[stream]]\nmin = [0.4, 0.4]\nmax = [0.6, 0.6]\n";

double stream_function(const Vec3& x) {
    const double k = 2 * std::numbers::pi;
    return std::sin(k * static_cast<double>(x.x())) * std::sin(k * static_cast<double>(x.y()));
}

}  // namespace

TEST_CASE("shifting does not mix ink that is constant along a steady flow", "[sim][ink]") {
    Simulation simulation = simulation_of(vortices("", ""));
    run_until(simulation, 1);
    const auto x = simulation.world().fluid.column<field::position>();
    const auto c = simulation.world().fluid.column<field::ink>();
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        sum += std::pow(static_cast<double>(c[i].x()) - 0.5 - 0.5 * stream_function(x[i]), 2);
        REQUIRE(c[i].y() == Approx(0.25).margin(1e-5));
        REQUIRE(c[i].x() >= 0);
        REQUIRE(c[i].x() <= 1);
    }
    const double off = std::sqrt(sum / static_cast<double>(x.size()));
    INFO("root mean square of the change: " << off);
    // A turn takes about 1 s. After 2 s the error is 0.013, and 0.032 without the correction for shifts.
    CHECK(off < 0.01);
}

TEST_CASE("a run with ink resumes bit-identically", "[sim][ink]") {
    const std::string scene =
        vortices("ink_diffusion = 1e-4", stream + "velocity = [\"1\", \"0\"]\ntime = 0.2\nink = [\"0.5+0.5*sin(20*t)\", \"x\", 1]\n");
    CHECK(differing_bits(scene, 0.2) == "");
}

TEST_CASE("fluid in a stream has the stream's ink, of time and place", "[sim][ink]") {
    Simulation simulation = simulation_of(vortices("", stream + "velocity = [\"0\", \"0\"]\ntime = 1e9\nink = [\"t\", \"y\"]\n"));
    run_until(simulation, 0.5);
    const auto x = simulation.world().fluid.column<field::position>();
    const auto c = simulation.world().fluid.column<field::ink>();
    int inside = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        if ((x[i] - Vec3(0.5f, 0.5f, 0)).cwiseAbs().maxCoeff() > 0.09f) continue;  // no step reaches that far
        ++inside;
        CHECK(c[i].x() == Approx(0.5).margin(0.05));
        CHECK(c[i].y() == Approx(static_cast<double>(x[i].y())).margin(0.02));
        CHECK(c[i].z() == 0);
    }
    CHECK(inside > 10);
}

TEST_CASE("an emitter sets its ink at the time at which fluid enters, and frames contain it", "[sim][ink]") {
    Simulation simulation =
        simulation_of(text::time(1, "fps = 10") + text::domain({-0.1, -0.3, -0.1}, {0.1, 0.3, 0.1}, "gravity = [0, 0, 0]") +
                      text::fluid(0.01) + text::models("none", "none") +
                      "[[emitter]]\nposition = [0, 0, 0]\nradius = 0.02\nspeed = 0.2\nink = [\"t < 0.5 ? 1 : 0\", 0, \"x > 0 ? 1 : 0\"]\n");
    run_until(simulation, 1);
    const Frame frame = Snapshots(simulation, {"ink"}).take(simulation, 1);
    REQUIRE(frame.vector.count("ink") == 1);
    const std::vector<Vec3f>& ink = frame.vector.at("ink");
    for (std::size_t i = 0; i < ink.size(); ++i) {
        const Vec3f& x = frame.position[i];
        // The column goes down at 0.2 m/s from 0.03 m above the opening, where fluid enters.
        const float entered = 1 - (0.03f - x.y()) / 0.2f;
        if (std::abs(entered - 0.5f) > 0.08f) CHECK(ink[i].x() == (entered < 0.5f ? 1.0f : 0.0f));
        CHECK(ink[i].z() == (x.x() > 0 ? 1.0f : 0.0f));
    }
}

TEST_CASE("ink diffusion without ink is refused", "[sim][ink]") {
    const std::string text = vortices("ink_diffusion = 1e-4", "", "");
    try {
        simulation_of(text);
        FAIL("no error");
    } catch (const InputError& error) {
        REQUIRE(error.problems().size() == 1);
        CHECK(error.problems()[0].what == "the scene has no ink");
    }
}

}  // namespace ink_scene_test

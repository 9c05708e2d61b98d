#include "engine/probes/coil_expectation.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <sstream>
#include <string>
#include <thread>

#include "engine/scene/read.h"
#include "tests/support/scene_text.h"

using namespace whorl;

namespace {

const std::string pouring_scene = test::text::time(1) + test::text::domain({-0.1, -0.1, -0.1}, {0.1, 0.2, 0.1}) +
                                  test::text::fluid(2e-3, 1000) + test::text::models("coupled") +
                                  test::text::emitter({0, 0.08, 0}, 5e-3, 0.25);

/// Input of the theory from the scene at 1 s, after turns of half a second and a fall of 8 cm; with `from` replaced by `to` first.
std::optional<CoilParameters> parameters_of(const std::string& from = "", const std::string& to = "", const std::string& more = "") {
    std::string text = pouring_scene;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    const Scene scene = read_scene_text(text + more, "pouring.toml");
    const auto poured = pouring(scene, make_plan(scene), Vec3d::Zero(), Vec3d::UnitY());
    return poured ? steady_parameters(*poured, Vec3d::UnitY(), 1, 0.5, 0.08) : std::nullopt;
}

}  // namespace

TEST_CASE("the input of the coil theory follows the scene, and is empty without such a thread", "[io][coil_theory]") {
    const auto plain = parameters_of();
    REQUIRE(plain);
    CHECK(plain->nozzle_radius == 5e-3);
    CHECK(plain->speed == 0.25);
    CHECK(plain->viscosity == Approx(1));
    CHECK(plain->gravity == 9.81);
    CHECK(plain->fall == 0.08);
    CHECK(parameters_of("speed = 0.25", "speed = 0.25\nviscosity = 300")->viscosity == Approx(0.3));
    CHECK(parameters_of("speed = 0.25", "speed = \"0.1 + 0.1*min(1, 4*t)\"")->speed == Approx(0.2));  // steady for the last turn
    CHECK(parameters_of("viscosity = 1000", "viscosity = 1000\nsurface_tension = 0.05")->surface_tension == Approx(5e-5));
    CHECK(parameters_of("", "", "[[emitter]]\nposition = [0.05, 0.15, 0]\nradius = 0.004\nspeed = 0.1\n")->nozzle_radius ==
          5e-3);  // the one on the axis

    CHECK_FALSE(parameters_of("speed = 0.25", "speed = \"0.25*(1+0.8*sin(12*t))\""));
    CHECK_FALSE(parameters_of("speed = 0.25", "speed = 0"));
    CHECK_FALSE(parameters_of("speed = 0.25", "speed = 0.25\nstop = 0.9"));
    CHECK_FALSE(parameters_of("speed = 0.25", "speed = 0.25\ndirection = [1, -1, 0]"));
    CHECK_FALSE(parameters_of("viscosity = 1000", "viscosity = \"1000 + 100*age\""));
    CHECK_FALSE(parameters_of("viscosity = 1000", "viscosity = \"1000 + 100*x\""));
    CHECK_FALSE(parameters_of("radius = 0.005", "shape = \"box\"\nwidth = 0.01\nthickness = 0.01"));
    CHECK_FALSE(parameters_of("max = [0.1, 0.2, 0.1]", "max = [0.1, 0.2, 0.1]\ngravity = [3, -9, 0]"));
    CHECK_FALSE(parameters_of("pressure = \"coupled\"", "pressure = \"wcsph\"\nviscosity = \"xsph\""));
    CHECK_FALSE(parameters_of("[[emitter]]\nposition = [0, 0.08, 0]\nradius = 0.005\nspeed = 0.25\n",
                              "[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.02, 0.02, 0.02]\n"));
}

TEST_CASE("a non-blocking theory query soon returns the same answer as a blocking one", "[io][coil_theory]") {
    CoilExpectation waiting(TheorySearch::wait), in_background(TheorySearch::in_background);
    CoilParameters p{5e-3, 0.1, 0.2, 9.81, 0.12, 0};
    const auto answer = waiting.at(p);
    REQUIRE(answer);
    CHECK_FALSE(in_background.at(p));
    std::optional<CoilTheory> soon;
    for (int k = 0; k < 600 && !soon; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(20)), soon = in_background.at(p);
    REQUIRE(soon);
    CHECK(soon->frequency == answer->frequency);
    p.fall *= 1.001;
    CHECK(waiting.at(p)->frequency == answer->frequency);  // near enough
    p.fall *= 1.05;
    CHECK(in_background.at(p)->frequency == answer->frequency);  // until the new solution is available
    CHECK(waiting.at(p)->frequency != answer->frequency);

    std::stringstream state;
    waiting.save(state);
    CoilExpectation resumed(TheorySearch::wait);
    resumed.load(state);
    p.fall *= 0.99;
    CHECK(resumed.at(p)->frequency == waiting.at(p)->frequency);
}

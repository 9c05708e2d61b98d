// Boxes in which the fluid is brought to a velocity.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/errors.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

std::string fluid_in_stream(const std::string& more) {
    return text::time(1, "fps = 4\nmax_step = 0.1") +
           text::domain({0, 0, 0}, {1, 1, 1}, "periodic = [true, true, true]\ngravity = [0, 0, 0]") + text::fluid(0.1) +
           text::block({0, 0, 0}, {1, 1, 1}) + more;
}

}  // namespace

TEST_CASE("a stream accelerates the fluid in its box as 1 - exp(-t/time), whatever the step", "[sim][stream]") {
    for (const double step : {0.1, 0.02}) {
        Simulation simulation = simulation_of(
            fluid_in_stream(text::models("none", "none") +
                            "[[stream]]\nmin = [0, 0, 0]\nmax = [1, 0.5, 1]\nvelocity = [\"0.2\", \"0\", \"0.1\"]\ntime = 0.5\n" +
                            fmt::format("[[change]]\ntime = 0\nkey = \"time.max_step\"\nvalue = {}\n", step)));
        run_until(simulation, 1);
        const Vec3 expected = static_cast<Real>(1 - std::exp(-2.0)) * Vec3(Real(0.2), 0, Real(0.1));
        const auto x = simulation.world().fluid.column<field::position>();
        const auto u = simulation.world().fluid.column<field::velocity>();
        for (std::size_t i = 0; i < x.size(); ++i) REQUIRE((u[i] - (x[i].y() < 0.5f ? expected : Vec3(0, 0, 0))).norm() < 1e-5f);
    }
}

TEST_CASE("a stream that the pressure model does not support, or outside the domain, is refused", "[sim][stream]") {
    const std::string stream = "[[stream]]\nmin = [0, 0, 0]\nmax = [1, 0.5, 1]\nvelocity = [\"0.2\", \"0\", \"0\"]\ntime = 0.5\n";
    CHECK_THROWS_WITH(simulation_of(fluid_in_stream(text::models("coupled") + stream)), Catch::Contains("does not support streams"));
    std::string open = fluid_in_stream("[[stream]]\nmin = [2, 0, 0]\nmax = [3, 1, 1]\ntime = 1\n");
    open.replace(open.find("[true"), 5, "[false");
    CHECK_THROWS_WITH(simulation_of(open), Catch::Contains("stream[0] lies outside of the domain"));
    CHECK_THROWS_WITH(simulation_of(fluid_in_stream("[[stream]]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n")), Catch::Contains("time"));
}

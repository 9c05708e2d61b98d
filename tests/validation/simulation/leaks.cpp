/// No particle passes through solids, neither by falling on them nor when they sweep through the fluid at the largest allowed speed.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch.h"

using namespace whorl;
using namespace whorl::test;

namespace leaks_test {

constexpr double d = 0.0125;

TEST_CASE("a block of water dropped into a container stays inside its walls, with every pressure model", "[validation][boundary]") {
    for (const std::string pressure : {"ppe", "wcsph"}) {
        INFO(pressure);
        Simulation simulation = simulation_of(text::time(0.5, "max_step = 5e-3") + text::domain({-0.05, -0.05, -0.05}, {0.25, 0.8, 0.2}) +
                                              text::fluid(d) + text::block({0.03, 0.2, 0.03}, {0.13, 0.3, 0.12}) +
                                              text::tank({0, 0, 0}, {0.2, 0.75, 0.15}) + text::models(pressure));
        const Index particles = simulation.world().fluid.size();
        run_until(simulation, 0.35);
        CHECK(simulation.totals().lost_particles == 0);
        CHECK(simulation.world().fluid.size() == particles);
        for (const Vec3& x : positions(simulation)) CHECK(static_cast<double>(simulation.world().solids.all[0].distance(x)) > -1e-3 * d);
    }
}

TEST_CASE("a plate of three spacings that sweeps through water by a spacing a step leaves no particle behind", "[validation][boundary]") {
    // 6.25 m/s for 16 ms, then it stops. fixed_step: the step is not cut to the plate's speed. The water goes up at the far wall, within 1
    // m.
    Simulation simulation =
        simulation_of(text::time(0.1, "fixed_step = 2e-3") + text::domain({-0.05, -0.05, -0.05}, {0.3, 2, 0.15}) + text::fluid(d) +
                      text::models("ppe") + text::block({0.0375, 0, 0}, {0.2375, 0.075, 0.1}) + text::tank({0, 0, 0}, {0.2375, 1.9, 0.1}) +
                      text::box({0, -0.05, -0.05}, {0.0375, 1.95, 0.15}, "position = [\"t < 0.016 ? 6.25*t : 0.1\", 0, 0]"));
    const Index particles = simulation.world().fluid.size();
    run_until(simulation, 0.1, [&] {
        int behind = 0;
        const double front = 0.0375 + static_cast<double>(simulation.world().solids.all[1].pose.translation.x());
        for (const Vec3& x : positions(simulation)) behind += static_cast<double>(x.x()) < front - 1e-3 * d;
        CHECK(behind == 0);
    });
    CHECK(simulation.totals().lost_particles == 0);
    CHECK(simulation.world().fluid.size() == particles);
}

TEST_CASE("no particle of a dam break passes a mesh plate of a fiftieth of a spacing, upright or tilted", "[validation][boundary]") {
    const ScratchFolder folder;
    constexpr double thickness = d / 50;
    for (const double tilt : {0.0, 0.4}) {
        std::ofstream mesh(folder / "plate.obj");
        for (const double z : {-0.02, 0.12})
            for (const auto& [y, side] : {std::pair{-0.02, -0.5}, {-0.02, 0.5}, {0.5, 0.5}, {0.5, -0.5}})
                mesh << fmt::format("v {} {} {}\n", 0.15 + tilt * y + side * thickness * std::hypot(1, tilt), y, z);
        mesh << "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        mesh.close();
        const std::string pressure = tilt > 0 ? "ppe" : "wcsph";
        INFO(tilt << ' ' << pressure);
        Simulation simulation = simulation_of(
            text::time(0.3, "max_step = 5e-3") + text::domain({-0.05, -0.05, -0.05}, {0.4, 0.5, 0.15}) + text::fluid(d) +
            text::block({0, 0, 0}, {0.1, 0.15, 0.1}) + text::tank({0, 0, 0}, {0.35, 0.45, 0.1}) +
            fmt::format("[[solid]]\nshape = \"mesh\"\nfile = \"{}\"\n", (folder / "plate.obj").string()) + text::models(pressure));
        run_until(simulation, 0.3);
        CHECK(simulation.totals().lost_particles == 0);
        double farthest = -1;
        for (const Vec3& x : positions(simulation))
            farthest = std::max(farthest, static_cast<double>(x.x()) - 0.15 - tilt * static_cast<double>(x.y()));
        CHECK(farthest < thickness);
        CHECK(farthest > -d);  // the water has arrived
    }
}

}  // namespace leaks_test

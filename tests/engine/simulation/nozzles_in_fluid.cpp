// Emitters that open below the surface, and into closed rooms.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/poured_honey.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace nozzles_test {

namespace {

/// Water 0.24 m deep in a tank, and a nozzle under its surface.
struct Tank {
    int dimensions = 2;
    double spacing = 0.03, speed = 1, start = 0, end = 0.2, height = 0.12, x = 0.3;
    std::string direction = "[-1, 0, 0]", more = "", fluid = "";

    std::string scene() const {
        const auto at = [&](double a, double b, double c) { return text::point(dimensions, a, b, c); };
        const std::string way = dimensions == 2 ? direction.substr(0, direction.rfind(',')) + "]" : direction;
        return text::time(end, "fps = 50\nmax_step = 5e-3") + text::domain(at(-0.5, -0.1, -0.3), at(0.5, 0.7, 0.3)) +
               text::fluid(spacing, 0, fluid) + text::block(at(-0.4, 0, -0.105), at(0.4, 0.24, 0.105)) +
               text::tank(at(-0.4, 0, -0.105), at(0.4, 0.64, 0.105)) +
               fmt::format("[[emitter]]\nposition = {}\ndirection = {}\nradius = 0.06\nspeed = {}\nstart = {}\n{}", at(x, height, 0), way,
                           speed, start, more);
    }
};

/// Runs to the end and checks mass and energy against the inflow of the nozzle.
/// @param rest speed of the fluid without a nozzle, as the model's particles settle [m/s]
void pours(const Tank& tank, double rest) {
    Simulation run = simulation_of(tank.scene());
    const auto outside = [&] {
        const auto role = run.world().fluid.column<field::role>();
        return static_cast<double>(std::count_if(role.begin(), role.end(), [](auto r) { return r >= 0; }));
    };
    const double first = outside(), mass = static_cast<double>(run.world().step.mass);
    const double area = tank.dimensions == 2 ? 0.12 : M_PI * 0.06 * 0.06, volume = run.plan().particle_volume();
    for (double t = 0.02; t < tank.end + 1e-9; t += 0.02) {
        run_until(run, t);
        INFO("t = " << t);
        const double pushed = tank.speed * std::max(0.0, t - tank.start);
        REQUIRE(largest_speed(run.world()) < 3 * tank.speed + rest);
        // The opening's area times the path, within the layer that is passing.
        REQUIRE(std::abs(run.totals().emitted_particles - pushed * area / volume) <= area * tank.spacing / volume);
        REQUIRE(std::abs(outside() - first - pushed * area / volume) <= area * tank.spacing / volume);
        // The fluid that the nozzle moved and the fluid that it accelerates: inside and about one radius ahead, at its speed and against
        // the weight of the fluid above it.
        const double moved = pushed + 3 * tank.spacing + 0.06, brought = 1000 * area * moved * (tank.speed * tank.speed + 9.81 * 0.24);
        REQUIRE(run.world().fluid.size() * mass * mean_square_speed(run) / 2 < brought + first * mass * rest * rest / 2);
    }
    CHECK(run.totals().lost_particles == 0);
}

}  // namespace

TEST_CASE("a nozzle below the surface pours without a burst, with exact mass and bounded energy", "[sim][emitter]") {
    SECTION("at once, and later") {
        for (const double start : {0.0, 0.1}) pours({.start = start}, 0);
    }
    SECTION("slow, fast") {
        pours({.speed = 0.2}, 0.2);  // the block begins a third of a spacing off the walls
        pours({.speed = 4, .end = 0.1}, 0);
    }
    SECTION("upwards, downwards, slanted, and from the wall") {
        pours({.height = 0.1, .x = 0, .direction = "[0, 1, 0]"}, 0);
        pours({.x = 0, .direction = "[0, -1, 0]"}, 0);
        pours({.x = 0, .direction = "[1, 1, 0]"}, 0);
        pours({.x = 0.4}, 0);
    }
    SECTION("a wall around an opening loses its boundary particles there, in all columns") {
        const Simulation open = simulation_of(Tank{.x = 0.4}.scene()), whole = simulation_of(Tank{.x = 0.2}.scene());
        const BoundaryParticles &boundary = open.world().boundary_particles, &all = whole.world().boundary_particles;
        REQUIRE(boundary.size() < all.size());
        for (const Index size : {static_cast<Index>(boundary.volume.size()), static_cast<Index>(boundary.behind.size()),
                                 static_cast<Index>(boundary.normal.size()), static_cast<Index>(boundary.position.size())})
            CHECK(size == boundary.size());
    }
    SECTION("from a wall, weakly compressible, in water and in the air") {
        pours({.speed = 0.2, .end = 0.1, .x = 0.4, .more = text::models("wcsph")}, 0.2);
        pours({.speed = 1, .end = 0.1, .height = 0.4, .x = 0.4, .more = text::models("wcsph")}, 0.2);
    }
    SECTION("weakly compressible, also slow, until the column's first layers have left") {
        for (const double start : {0.0, 0.05}) pours({.start = start, .end = 0.1, .more = text::models("wcsph")}, 0);
        pours({.speed = 0.3, .end = 0.5, .more = text::models("wcsph")}, 0);
    }
}

TEST_CASE("the fluid around a nozzle at rest is as calm as without a nozzle", "[sim][emitter]") {
    for (const std::string pressure : {"ppe", "wcsph"}) {
        const auto fastest = [&](const std::string& direction) {
            std::string text =
                Tank{.start = 1, .height = 0.1, .x = 0.1, .direction = direction, .more = "[models]\npressure = \"" + pressure + "\"\n"}
                    .scene();
            if (direction == "[1, 0, 0]") text.replace(text.find("[[emitter]]"), text.find("[models]") - text.find("[[emitter]]"), "");
            Simulation run = simulation_of(text);
            double all = 0;
            for (double t = 0.01; t < 0.065; t += 0.01) run_until(run, t), all = std::max(all, largest_speed(run.world()));
            return all;
        };
        const double without = fastest("[1, 0, 0]");
        // A fall by a 15th of a spacing gives .2 m/s. When the pipe's particles replaced those of the block, it was 1 to 2 m/s.
        for (const std::string direction : {"[-1, 0, 0]", "[0, 1, 0]", "[-1, 1, 0]"}) {
            INFO(pressure << ' ' << direction);
            CHECK(fastest(direction) < without + 0.2);
        }
    }
}

TEST_CASE("a submerged nozzle pours in 3D, with every pressure model", "[sim][emitter]") {
    Tank tank{.dimensions = 3, .end = 0.04};
    pours(tank, 0);
    tank.more = text::models("wcsph");
    pours(tank, 0);
    tank.more = text::models("coupled"), tank.fluid = "viscosity = 20\n";
    pours(tank, 0);
}

TEST_CASE("the projection refuses a pipe in the fluid, because fluid could enter it from behind", "[sim][emitter]") {
    const std::string projection = "[pressure]\nform = \"projection\"\n";
    CHECK_THROWS_WITH(simulation_of(Tank{.x = 0.1, .more = projection}.scene()),
                      Catch::Contains("lets fluid flow from behind into the pipe of emitter[0]"));
    CHECK_NOTHROW(simulation_of(Tank{.speed = 0.1, .x = 0.4, .more = projection}.scene()));
}

TEST_CASE("a nozzle fills a pipe of its width, or up to one spacing narrower, at its rate", "[sim][emitter]") {
    constexpr double d = 1e-3, radius = 4 * d, speed = 0.2;
    for (const std::string& models : {text::models("ppe"), text::models("wcsph")})
        for (const double narrower : {0.0, 0.3, 1.0})
            for (const double opening : {-0.015, 0.0}) {  // in the middle of the pipe, at its end
                INFO(models << narrower << ' ' << opening);
                const double wall = radius - narrower * d;
                Simulation run = simulation_of(
                    text::time(0.05) + text::domain({-0.03, -0.01}, {0.03, 0.01}, "gravity = [0, 0]") + text::fluid(d) + models +
                    fmt::format("[[emitter]]\nposition = [{}, 0]\ndirection = [1, 0]\nradius = {}\nspeed = {}\n", opening, radius, speed) +
                    text::box({-0.025, wall}, {0, 0.01}) + text::box({-0.025, -0.01}, {0, -wall}));
                for (double t = 0.01; t < 0.05 + 1e-9; t += 0.01) {
                    run_until(run, t);
                    REQUIRE(largest_speed(run.world()) < 2 * speed);
                    REQUIRE(std::abs(run.totals().emitted_particles - t * speed * 2 * radius / (d * d)) <= 2 * radius / d);
                }
                CHECK(run.totals().lost_particles == 0);
            }
}

TEST_CASE("a run with a nozzle in the fluid resumes bit-identically", "[sim][emitter]") {
    const Tank tank{.start = 0.1};
    CHECK(differing_bits(tank.scene(), 0.12) == "");
    const Tank moving{.direction = "[\"-cos(3*t)\", \"sin(3*t)\", 0]", .more = "position = [\"0.3-0.2*t\", 0.4]\n"};
    std::string scene = moving.scene();
    scene.replace(scene.find("position = [0.3"), scene.find("direction") - scene.find("position = [0.3"), "");
    CHECK(differing_bits(scene, 0.12) == "");
}

namespace {

/// A closed box of 8 x 8 (x 8) lattice sites with seven full layers. The nozzle emits more than fits into the eighth.
std::string closed_box(int dimensions, const std::string& more, const std::string& domain = "", double end = 0.3) {
    const auto corner = [&](double x, double y) { return text::point(dimensions, x, y, x); };
    return text::time(end, "fps = 50") + text::domain(corner(-0.06, -0.06), corner(0.06, 0.06), domain) + text::fluid(0.01) +
           text::block(corner(-0.04, -0.04), corner(0.04, 0.02)) + text::tank(corner(-0.04, -0.04), corner(0.04, 0.04)) +
           fmt::format("[[emitter]]\nposition = {}\ndirection = {}\nradius = 0.018\nspeed = 0.5\n{}", text::point(dimensions, 0, 0.02, 0),
                       text::point(dimensions, 0, -1, 0), more);
}

bool warns(const std::string& text) { return warnings_with(simulation_of(text).plan(), "more comes than fits") == 1; }

}  // namespace

TEST_CASE("the plan names a closed room that overflows, but not a room that fluid can leave", "[sim][emitter]") {
    for (const int dimensions : {2, 3}) {
        const std::string drain = text::drain(text::point(dimensions, -0.04, -0.04, -0.01), text::point(dimensions, -0.03, -0.03, 0.01));
        CHECK(warns(closed_box(dimensions, "")));
        CHECK_FALSE(warns(closed_box(dimensions, "stop = 0.005\n")));
        CHECK_FALSE(warns(closed_box(dimensions, drain)));
        std::string open = closed_box(dimensions, "");
        const auto at = open.find("[[solid]]");
        open.replace(at, open.find("[[emitter]]") - at, "");
        CHECK_FALSE(warns(open));  // no walls: it leaves the domain
    }
    // A full periodic box is also a closed room, with the volume between floor and lid.
    std::string round = closed_box(2, "", "periodic = [true, false]\n");
    CHECK(warns(round));
    const Plan plan = simulation_of(closed_box(3, "")).plan();
    REQUIRE(plan.rooms.size() == 1);
    // 8^3 cells less the pipe, a cylinder of 18 mm radius over the 20 mm up to the lid.
    CHECK(plan.rooms[0].volume == Approx(0.08 * 0.08 * 0.08 - M_PI * 0.018 * 0.018 * 0.02).epsilon(0.01));
    CHECK(plan.rooms[0].box.min().y() == Approx(-0.04).margin(0.003));
    ClosedRoom rounded;
    rounded.box = Eigen::AlignedBox3d(Vec3d(4e-11, -0.2, 0), Vec3d(0.3, -3e-12, 0.5));
    CHECK(rounded.text() == "the closed room from (0, -0.2, 0) to (0.3, 0, 0.5) m");
}

TEST_CASE("a full room stops its emitter, which is reported once, and stays calm", "[sim][emitter]") {
    const auto [dimensions, more] =
        GENERATE(table<int, std::string>({{2, ""}, {3, ""}, {2, text::models("wcsph")}, {3, text::models("wcsph")}}));
    INFO(dimensions << ' ' << more);
    Simulation run = simulation_of(closed_box(dimensions, more));
    int reported = 0;
    double fastest = 0, shortest = 1;
    for (int frame = 1; frame <= 15; ++frame)
        while (run.time() < 0.02 * frame - 1e-12) {
            const StepReport& report = run.step(0.02 * frame);
            REQUIRE_FALSE(report.diverged);
            reported += !report.full.empty();
            if (frame > 10) fastest = std::max(fastest, largest_speed(run.world())), shortest = std::min(shortest, run.totals().last_step);
        }
    CHECK(reported == 1);
    CHECK(fastest < 3 * 0.5);
    CHECK(shortest > (more.empty() ? 1e-3 : 1e-5));
}

TEST_CASE("a lid that squeezes a full room by 1 % is reported once, and steps stay long", "[sim][emitter]") {
    Simulation run =
        simulation_of(text::time(0.1, "fps = 50") + text::domain({-0.06, -0.06}, {0.06, 0.1}) + text::fluid(0.01) + text::models("ppe") +
                      text::block({-0.04, -0.04}, {0.04, 0.04}) + text::tank({-0.04, -0.04}, {0.04, 0.08}) +
                      text::box({-0.04, 0.0405}, {0.04, 0.055}, "position = [0, \"-0.1*min(t,0.01)\"]"));
    std::string reported;
    while (run.time() < 0.1 - 1e-12) {
        const StepReport& report = run.step(0.1);
        REQUIRE_FALSE(report.diverged);
        if (reported.empty()) reported = report.full;
        REQUIRE(run.totals().steps < 200);  // 20 at max_step; a pressure that keeps its level takes steps of 20 microseconds
    }
    CHECK(reported.starts_with("fluid without room at "));
    CHECK(reported.ends_with("m^2 are too much after this step"));
}

}  // namespace nozzles_test

/// Fluid at rest between the solids of a scene: read, plan, simulate.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/io/diagnostics.h"
#include "engine/models/pressure/constraint.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "tests/support/runs.h"
#include "tests/support/scenes.h"

using namespace whorl;
using namespace whorl::test;

namespace at_rest_test {

namespace {

constexpr double d = 0.01, g = 9.81, rho_0 = 1000;

double max_speed(const Simulation& simulation) {
    double most = 0;
    for (const Vec3& u : simulation.world().fluid.column<field::velocity>()) most = std::max(most, static_cast<double>(u.norm()));
    return most;
}

/// Water of the given height [m] and spacing [m] in the solids of `rest`, with weakly compressible pressure and all its defaults.
Scene water(const std::string& rest, double spacing, const std::string& sampling) {
    return read_scene_text(fmt::format(R"toml([time]
end = 1.2
max_step = 2e-3
[fluid]
spacing = {}
[models]
pressure = "wcsph"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [0.06, 0.15, 0.06]
sampling = "{}"
{})toml",
                                       spacing, sampling, rest),
                           "water.toml");
}

void weakly_compressible_rest(const std::string& form, double spacing, const std::string& sampling, double settled = 1) {
    // From a lattice (which melts within a second) and from an irregular start. It is the difference of pressure between
    // the lowest and the middle third that is held against the weight between them: the slot has no surface that could set the pressure to
    // zero, and at the surface of the box the topmost layer, whose kernel sums fall short, carries none.
    const std::string box = R"toml([domain]
min = [-0.05, -0.05, -0.05]
max = [0.11, 0.2, 0.11]
[[solid]]
shape = "box"
container = true
min = [0, 0, 0]
max = [0.06, 0.2, 0.06]
)toml",
                      slot = R"toml([domain]
min = [0, -0.05, 0]
max = [0.06, 0.2, 0.06]
periodic = [true, false, true]
[[solid]]
shape = "plane"
[[solid]]
shape = "plane"
position = [0, 0.15, 0]
normal = [0, -1, 0]
)toml";
    INFO(form << ", spacing " << spacing << ", " << sampling);
    const Scene scene = water(form == "box" ? box : slot, spacing, sampling);
    Simulation simulation(scene, make_plan(scene));
    run_until(simulation, settled);
    double difference = 0, exact = 0, fastest = 0;
    while (simulation.time() < settled + 0.2) {
        REQUIRE_FALSE(simulation.step(settled + 0.2).diverged);
        const auto x = simulation.world().fluid.column<field::position>();
        const auto p = simulation.world().fluid.column<field::pressure>();
        double pressure[2] = {0, 0}, height[2] = {0, 0};
        int count[2] = {0, 0};
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (x[i].y() > 0.1) continue;
            const int upper = x[i].y() > 0.05;
            pressure[upper] += p[i], height[upper] += x[i].y(), ++count[upper];
        }
        difference += pressure[0] / count[0] - pressure[1] / count[1];
        exact += rho_0 * g * (height[1] / count[1] - height[0] / count[0]);
        fastest = std::max(fastest, max_speed(simulation));
    }
    CHECK(difference / exact == Approx(1).epsilon(0.02));
    CHECK(fastest < 0.02 * std::sqrt(2 * g * 0.15));
    CHECK(simulation.totals().lost_particles == 0);
}

}  // namespace

TEST_CASE("weakly compressible water comes to rest in a full slot, with the pressure of its weight within 2 %", "[validation][sim]") {
    weakly_compressible_rest("slot", 0.01, "blue_noise", 0.5);
}

TEST_CASE("weakly compressible water comes to rest in a box from any start, with its weight within 2 %", "[validation][sim][long]") {
    for (const std::string sampling : {"lattice", "blue_noise"}) weakly_compressible_rest("box", 0.01, sampling);
    weakly_compressible_rest("slot", 0.01, "lattice");
    for (const std::string form : {"box", "slot"})
        for (const std::string sampling : {"lattice", "blue_noise"}) weakly_compressible_rest(form, 0.0075, sampling);
}

TEST_CASE("a column of 30 layers presses on a plane with its weight within 2 %, in both pressure models", "[validation][sim][long]") {
    // Periodic sideways; the particles of the plane are what sample_solids makes of it. Mean over 0.2 s after 1.0 s of settling.
    const std::string smoothed = "viscosity = \"xsph\"\n[viscosity]\nalpha = 0.05\n";  // wcsph has its own dampers
    for (const std::string pressure : {"ppe", "wcsph"}) {
        INFO(pressure);
        Simulation simulation = simulation_of(scene_of(
            WaterColumn{0.06, 30 * d, d, 1.2, 2e-3}, "[models]\npressure = \"" + pressure + "\"\n" + (pressure == "ppe" ? smoothed : "")));
        run_until(simulation, 1.0);
        double sum = 0, exact = 0;
        while (simulation.time() < 1.2) {
            REQUIRE_FALSE(simulation.step(1.2).diverged);
            const auto x = simulation.world().fluid.column<field::position>();
            const auto p = simulation.world().fluid.column<field::pressure>();
            for (std::size_t i = 0; i < x.size(); ++i)
                if (x[i].y() < 3 * d) sum += p[i], exact += rho_0 * g * (30 * d - x[i].y());
        }
        CHECK(sum / exact == Approx(1).epsilon(0.02));
        CHECK(max_speed(simulation) < 0.02 * std::sqrt(2 * g * 30 * d));
        CHECK(simulation.totals().lost_particles == 0);
    }
}

namespace {

/// Energy of motion and of height over m g H.
struct Energy {
    double moving = 0, above_start = 0;
};

void published_rest(const std::string& name, double correction) {
    // 2 s from a lattice, without viscosity. What the lattice sets free as it melts (0.2 to 0.6 % of m g H) dies, and nothing else is there
    // that could do work but the unevenness of the start, which a share of 1 takes back in one step (2e-4 of m g H). The motion that is
    // left: 4e-6 to 6e-5. The pressure over the last second: the mean of the lower half under the settled level; in the full box, which has
    // no zero of pressure, the difference between two heights. 0.7 % too low to 1.2 % too high (1 % was aimed at): a settled packing does
    // not press alike in all directions.
    constexpr double spacing = 0.0125, H = 12 * spacing, side = 6 * spacing;
    INFO(name << ", correction " << correction);
    const double width = name == "slot" ? 5 * spacing : side;
    const std::string walls = name == "column" ? "[[solid]]\nshape = \"plane\"\n"
                              : name == "slot"
                                  ? fmt::format(
                                        "[[solid]]\nshape = \"plane\"\n[[solid]]\nshape = \"plane\"\nnormal = [1, 0, 0]\n"
                                        "[[solid]]\nshape = \"plane\"\nposition = [{}, 0, 0]\nnormal = [-1, 0, 0]\n",
                                        width)
                                  : fmt::format("[[solid]]\nshape = \"box\"\ncontainer = true\nmin = [0, 0, 0]\nmax = [{0}, {1}, {0}]\n",
                                                side, name == "full box" ? H : 2 * H);
    const bool around_x = name == "column", around_z = name == "column" || name == "slot";
    Simulation simulation =
        simulation_of(fmt::format(R"toml([time]
end = 2
max_step = 2e-3
[domain]
min = [{1}, -0.05, {2}]
max = [{3}, 0.35, {4}]
periodic = [{5}, false, {6}]
[fluid]
spacing = {7}
[models]
pressure = "ppe"
[pressure]
form = "projection"
source = "density"
correction = {8}
[[block]]
shape = "box"
min = [0, 0, 0]
max = [{0}, {9}, {10}]
{11})toml",
                                  width, around_x ? 0 : -0.05, around_z ? 0 : -0.05, around_x ? width : width + 0.05,
                                  around_z ? side : side + 0.05, around_x, around_z, spacing, correction, H, side, walls));
    const auto energy = [&] {
        const auto x = simulation.world().fluid.column<field::position>();
        const auto u = simulation.world().fluid.column<field::velocity>();
        Energy e;
        for (std::size_t i = 0; i < x.size(); ++i) {
            e.moving += static_cast<double>(u[i].squaredNorm()) / 2 / static_cast<double>(x.size()) / (g * H);
            e.above_start += static_cast<double>(x[i].y()) / static_cast<double>(x.size()) / H;
        }
        e.above_start += e.moving;
        return e;
    };
    const double start = energy().above_start;
    double difference = 0, expected = 0, highest = 0;
    while (simulation.time() < 2) {
        REQUIRE_FALSE(simulation.step(2).diverged);
        highest = std::max(highest, energy().above_start - start);
        if (simulation.time() < 1) continue;
        const auto x = simulation.world().fluid.column<field::position>();
        const auto p = simulation.world().fluid.column<field::pressure>();
        double pressure[2] = {0, 0}, height[2] = {0, 0}, level = 0;
        int count[2] = {0, 0};
        for (const Vec3& one : x) level += 2 * static_cast<double>(one.y()) / static_cast<double>(x.size());
        for (std::size_t i = 0; i < x.size(); ++i) {
            const int upper = x[i].y() > Real(level / 2);
            pressure[upper] += p[i], height[upper] += x[i].y(), ++count[upper];
        }
        const bool full = name == "full box";
        difference += pressure[0] / count[0] - (full ? pressure[1] / count[1] : 0);
        expected += rho_0 * g * ((full ? height[1] / count[1] : level) - height[0] / count[0]);
    }
    CAPTURE(energy().moving, max_speed(simulation) / std::sqrt(g * H), highest);
    CHECK(highest < 3e-4 * correction);
    CHECK(energy().moving < 5e-4);
    CHECK(difference / expected == Approx(1).epsilon(0.015));
    CHECK(simulation.totals().lost_particles == 0);
    CHECK(simulation.totals().unconverged_solves == 0);
}

}  // namespace

TEST_CASE(
    "pressure.source density: water in a column, in boxes and in a slot of 5 spacings gains no energy and comes to rest, with the pressure "
    "of its weight within 1.5 %",
    "[validation][sim]") {
    for (const std::string name : {"column", "open box", "full box", "slot"}) published_rest(name, 0.1);
}

TEST_CASE("pressure.source density: the same where a step corrects all of the density error", "[validation][sim]") {
    for (const std::string name : {"column", "open box", "full box", "slot"}) published_rest(name, 1);
}

TEST_CASE("pressure.source density: water between floor and ceiling rests with the pressure of its weight", "[validation][sim]") {
    // Within 1 %. No free surface: the pressure has no natural zero. The ceiling must mirror the pressure less the weight up to it, or the
    // topmost layer falls (the run diverged within 0.2 s). Held until the lattice, which is no stable packing, starts to melt (0.3 s).
    Simulation simulation = simulation_of(scene_of(WaterColumn{0.1, 10 * d, d, 0.2, 2e-3}, R"toml([models]
pressure = "ppe"
[pressure]
form = "projection"
source = "density"
[[solid]]
shape = "plane"
position = [0, 0.1, 0]
normal = [0, -1, 0]
)toml"));
    run_until(simulation, 0.1);
    // Means over 0.1 s, as for the columns, of the lowest and the topmost of the ten layers.
    double low = 0, high = 0;
    int steps = 0;
    for (; simulation.time() < 0.2; ++steps) {
        REQUIRE_FALSE(simulation.step(0.2).diverged);
        const auto x = simulation.world().fluid.column<field::position>();
        const auto p = simulation.world().fluid.column<field::pressure>();
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (x[i].y() < d) low += p[i] / 100.0;
            if (x[i].y() > 9 * d) high += p[i] / 100.0;
        }
    }
    CHECK(max_speed(simulation) < 0.002 * std::sqrt(2 * g * 10 * d));
    CHECK((low - high) / steps == Approx(rho_0 * g * 9 * d).epsilon(0.01));
}

namespace {

struct Rest {
    double early, late;       ///< root mean square speed over sqrt(2 g H), mean over 0.4 to 0.6 s and over the last 0.2 s
    double fastest;           ///< largest speed over sqrt(2 g H), mean over the last 0.2 s
    double density, densest;  ///< largest mean and largest single relative density error over the last 0.2 s
    bool keeps_densities;     ///< the form bounds them
    long lost;
};

/// Water to a height H between solids, from a lattice, for `end` seconds.
Rest settle(const std::string& solids, const std::string& periodic, const Vec3d& fill, const std::string& more, double spacing, double end,
            double max_step = 5e-3) {
    const std::string low_x = periodic[1] == 't' ? "0" : "-0.05", low_z = periodic.find("true]") != std::string::npos ? "0" : "-0.05";
    const auto text = [](double value) { return std::to_string(value); };
    const auto side = [&](double size, const std::string& low) { return low == "0" ? text(size) : text(size + 0.05); };
    const Scene scene =
        read_scene_text("[time]\nend = " + text(end) + "\nmax_step = " + text(max_step) + "\n[domain]\nmin = [" + low_x + ", -0.05, " +
                            low_z + "]\nmax = [" + side(fill.x(), low_x) + ", 0.4, " + side(fill.z(), low_z) + "]\nperiodic = " + periodic +
                            "\n[fluid]\nspacing = " + text(spacing) + "\n[models]\npressure = \"ppe\"\n" + more +
                            "[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [" + text(fill.x()) + ", " + text(fill.y()) + ", " +
                            text(fill.z()) + "]\n" + solids,
                        "rest.toml");
    Simulation simulation(scene, make_plan(scene));
    const double scale = std::sqrt(2 * g * fill.y());
    int steps = 0;
    const auto mean_square = [&] {
        double sum = 0;
        const auto u = simulation.world().fluid.column<field::velocity>();
        for (const Vec3& one : u) sum += static_cast<double>(one.squaredNorm()) / static_cast<double>(u.size());
        return sum / (scale * scale);
    };
    Rest rest{};
    rest.keeps_densities = simulation.plan().facts.pressure.form == PressureForm::constraint;
    run_until(simulation, 0.4);
    for (steps = 0; simulation.time() < 0.6; ++steps) {
        REQUIRE_FALSE(simulation.step(0.6).diverged);
        rest.early += mean_square();
    }
    rest.early = std::sqrt(rest.early / steps);
    run_until(simulation, end - 0.2);
    for (steps = 0; simulation.time() < end; ++steps) {
        REQUIRE_FALSE(simulation.step(end).diverged);
        rest.late += mean_square();
        rest.fastest += max_speed(simulation) / scale;
        double mean = 0;
        const auto rho = simulation.world().fluid.column<field::density>();
        for (Real one : rho) {
            const double error = std::max(0.0, static_cast<double>(one) / rho_0 - 1);
            mean += error / static_cast<double>(rho.size());
            rest.densest = std::max(rest.densest, error);
        }
        rest.density = std::max(rest.density, mean);
    }
    rest.late = std::sqrt(rest.late / steps);
    rest.fastest /= steps;
    rest.lost = simulation.totals().lost_particles;
    return rest;
}

const std::string open_box = "[[solid]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.2, 0.1]\ncontainer = true\n";
const std::string full_box = "[[solid]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\ncontainer = true\n";
const std::string floor_and_ceiling =
    "[[solid]]\nshape = \"plane\"\n[[solid]]\nshape = \"plane\"\nposition = [0, 0.1, 0]\nnormal = [0, -1, 0]\n";
const std::string slot =
    "[[solid]]\nshape = \"plane\"\n[[solid]]\nshape = \"plane\"\nnormal = [1, 0, 0]\n"
    "[[solid]]\nshape = \"plane\"\nposition = [0.06, 0, 0]\nnormal = [-1, 0, 0]\n";

}  // namespace

namespace {

const std::string xsph = "viscosity = \"xsph\"\n[viscosity]\nalpha = 0.05\n";

void comes_to_rest(const std::string& name, const std::string& solids, const std::string& periodic, const Vec3d& fill,
                   const std::string& viscosity) {
    // A lattice is no stable packing: it melts, and what its fall to a denser one sets free (1 % of the height) has to die out. Speeds in
    // units of sqrt(2 g H): the root mean square below 0.7 % (0.2 to 0.4 % is reached), and falling: below half of what it was at 0.5 s
    // (0.7 to 2 %, by when the lattice melts). Single particles that find a better place jump: the fastest of 1000, 1 to 3 % from run to
    // run (float and double are two runs), below 5 %. The densest particle scatters in the same way (.02 to .3 %), the mean does not.
    INFO(name << (viscosity.empty() ? "" : ", XSPH"));
    const Rest rest = settle(solids, periodic, fill, viscosity, d, 2.4);
    CAPTURE(rest.early, rest.late, rest.fastest, rest.density, rest.densest);
    CHECK(rest.fastest < 0.05);
    CHECK(rest.late < 0.02 / 3);
    CHECK(rest.lost == 0);
    // Cases that fill their space without smoothing use the projection: it has no kernel sums, and its lattice does not melt.
    if (!rest.keeps_densities) return;
    CHECK(rest.late < rest.early / 2);
    CHECK(rest.density < 1e-3);
    CHECK(rest.densest < 1e-2);
}

}  // namespace

TEST_CASE("water comes to rest in an open box, and with viscosity in a full closed one", "[validation][sim]") {
    comes_to_rest("open box", open_box, "[false, false, false]", {0.1, 0.1, 0.1}, "");
    comes_to_rest("full closed box", full_box, "[false, false, false]", {0.1, 0.1, 0.1}, xsph);
}

TEST_CASE("a block of water at side walls stays at rest, and its corners have rho g depth within 5 %", "[validation][sim]") {
    // Walls show images, so the lattice next to them is held as inside: up to 7e-5 of its potential energy moves while its excess of 0.09 %
    // is corrected, 8e-7 after 0.1 s (9e-4 without images, when the force along walls was 0.84 of a gradient's). Later the lattice melts.
    // 2D: 1.04 in corners. 3D, 12 particles across: 1.02 in edges and corners (1.14 in corners without images), 6e-8 to 5e-7 move.
    const bool plane = GENERATE(true, false);
    constexpr double spacing = 0.0125;
    const double width = plane ? 0.2 : 0.15;
    const auto deep = [&](double z) { return plane ? std::string() : fmt::format(", {}", z); };
    Simulation simulation = simulation_of(fmt::format(R"toml([time]
end = 2
[domain]
dimensions = {0}
min = [-0.05, -0.05{1}]
max = [0.25, 0.3{2}]
[fluid]
spacing = {3}
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0{4}]
max = [{5}, {5}{6}]
[[solid]]
shape = "box"
min = [0, 0{4}]
max = [{5}, 0.3{6}]
container = true
slip = "free"
[[probe]]
name = "tank"
kind = "solid"
solid = 0
)toml",
                                                      plane ? 2 : 3, deep(-0.05), deep(0.25), spacing, deep(0), width, deep(width)));
    double most = 0, corners = 0, exact = 0;
    while (simulation.time() < 0.1) {
        REQUIRE_FALSE(simulation.step(0.1).diverged);
        double squares = 0;
        const auto u = simulation.world().fluid.column<field::velocity>();
        for (const Vec3& one : u) squares += static_cast<double>(one.squaredNorm()) / static_cast<double>(u.size());
        most = std::max(most, squares / (g * width));
    }
    CHECK(most < 2e-4);
    for (int frame = 5; frame <= (plane ? 40 : 12); ++frame) {
        run_until(simulation, 0.05 * frame);
        const auto x = simulation.world().fluid.column<field::position>();
        const auto p = simulation.world().fluid.column<field::pressure>();
        const auto outer = [&](Real at) { return std::abs(static_cast<double>(at) - width / 2) > width / 2 - spacing; };
        for (std::size_t i = 0; i < x.size(); ++i)
            if (x[i].y() < Real(spacing) && outer(x[i].x()) && (plane || outer(x[i].z())))
                corners += p[i], exact += rho_0 * g * (width - static_cast<double>(x[i].y()));
    }
    CHECK(corners / exact == Approx(1).epsilon(0.05));
}

namespace {

/// 16 x 16 particles of water in 2D, in a tank .2 m wide. @param time keys of [time] @param tank its solids
std::string square_of_water(const std::string& time, const std::string& tank) {
    return "[time]\nend = 1\n" + time + R"toml([domain]
dimensions = 2
min = [-0.05, -0.05]
max = [0.25, 0.3]
[fluid]
spacing = 0.0125
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0]
max = [0.2, 0.2]
)toml" + tank;
}

}  // namespace

TEST_CASE("still water has rho g depth within 5 % at 99 of 100 frame times for any rhythm of steps", "[validation][sim]") {
    // Mean pressure of 16 x 16 particles over the weight's. The last steps before a frame are half as long as the others. It was .97
    // to 1.24 with steps of 2 and 1 ms, and .60 to 1.30 with 1 and .5 ms, when a step left a residual that all particles share. Where
    // neighbours change places, a short step pushes harder: one frame of 330 has 1.057.
    struct Rhythm {
        double max_step, fps;
    };
    const Rhythm rhythm = GENERATE(Rhythm{5e-3, 200}, Rhythm{2e-3, 165}, Rhythm{1e-3, 165}, Rhythm{1e-3, 60});
    INFO("max_step " << rhythm.max_step << " fps " << rhythm.fps);
    Simulation simulation = simulation_of(square_of_water(fmt::format("max_step = {}\n", rhythm.max_step), R"toml([[solid]]
shape = "box"
min = [0, 0]
max = [0.2, 0.3]
container = true
slip = "free"
)toml"));
    int frames = 0, off = 0;
    double farthest = 0;
    for (int frame = 1; frame < 0.7 * rhythm.fps; ++frame) {
        run_until(simulation, frame / rhythm.fps);
        if (frame < 0.2 * rhythm.fps) continue;
        const auto x = simulation.world().fluid.column<field::position>();
        const auto p = simulation.world().fluid.column<field::pressure>();
        double sum = 0, exact = 0;
        for (std::size_t i = 0; i < x.size(); ++i) sum += p[i], exact += rho_0 * g * (0.2 - static_cast<double>(x[i].y()));
        const double error = std::abs(sum / exact - 1);
        ++frames, off += error > 0.05, farthest = std::max(farthest, error);
    }
    CHECK(off <= frames / 80);
    CHECK(farthest < 0.08);
}

TEST_CASE("a tank of boxes, thin or thick, holds still water as calm as one container", "[validation][sim]") {
    // K/P is 1e-7 as in a container. It was 1e-4 to 3e-4 when faces that lie on each other, or the far edges of a thin box, spoilt images.
    const double wall = GENERATE(0.025, 0.05);
    Simulation simulation = simulation_of(square_of_water("", fmt::format(R"toml([[solid]]
shape = "box"
min = [-{0}, -{0}]
max = [{1}, 0]
[[solid]]
shape = "box"
min = [-{0}, 0]
max = [0, 0.3]
[[solid]]
shape = "box"
min = [0.2, 0]
max = [{1}, 0.3]
)toml",
                                                                          wall, 0.2 + wall)));
    run_until(simulation, 0.1);
    const Measures now = measure(simulation.world(), Vec3d(0, -g, 0), 1);
    CHECK(now.kinetic_energy < 1e-5 * now.potential_energy);
    CHECK(now.density_error_max < 1e-3);
}

TEST_CASE("a deep tank in 2D stays calm when its first steps are short, on a lattice and jittered", "[validation][sim]") {
    // 100 layers, d = 1 cm, steps of 0.1 ms. The lattice is 0.09 % too dense in 2D, a jittered block about as much: corrected within a few
    // steps that threw the water up, at 4.5 m/s in the mean. The correction brings 3 % of sqrt(g L) + the mean speed to a length L =
    // 0.32 m of the fluid, so three times that to the surface, and half of it in the mean: 10 % of sqrt(g L) is twice the mean.
    for (const std::string sampling : {"lattice", "jittered"}) {
        INFO(sampling);
        Simulation simulation = simulation_of(fmt::format(R"toml([time]
end = 1
max_step = 1e-4
[domain]
dimensions = 2
min = [-0.05, -0.05]
max = [0.15, 1.3]
[fluid]
spacing = 0.01
[[block]]
shape = "box"
min = [0, 0]
max = [0.1, 1]
sampling = "{}"
[[solid]]
shape = "box"
container = true
min = [0, 0]
max = [0.1, 1.2]
)toml",
                                                          sampling));
        double most = 0;
        for (int k = 1; k <= 20; ++k) {
            run_until(simulation, 1e-3 / 2 * k);
            double up = 0;
            const auto u = simulation.world().fluid.column<field::velocity>();
            for (const Vec3& one : u) up += static_cast<double>(one.y()) / static_cast<double>(u.size());
            most = std::max(most, up);
        }
        CHECK(most < 0.1 * std::sqrt(g * 0.32));
    }
}

TEST_CASE("water that fills the gap between floor and ceiling lies still", "[validation][sim]") {
    // No surface makes room for what the particles' motion bends. Root mean square over sqrt(2 g H): 0.010; where the pressure is asked for
    // it nevertheless, 0.24.
    const Rest rest = settle(floor_and_ceiling, "[true, false, true]", {0.1, 0.1, 0.1}, xsph, d, 1);
    CHECK(rest.early < 0.02);
    CHECK(rest.lost == 0);
}

TEST_CASE("water comes to rest between floor and ceiling, in a slot and in inverted boxes", "[validation][sim][long]") {
    comes_to_rest("open box", open_box, "[false, false, false]", {0.1, 0.1, 0.1}, xsph);
    comes_to_rest("full closed box", full_box, "[false, false, false]", {0.1, 0.1, 0.1}, "");
    for (const std::string& viscosity : {std::string(), xsph}) {
        comes_to_rest("floor and ceiling", floor_and_ceiling, "[true, false, true]", {0.1, 0.1, 0.1}, viscosity);
        comes_to_rest("slot", slot, "[false, false, true]", {0.06, 0.2, 0.06}, viscosity);
    }
}

TEST_CASE("water in an open box comes to rest with half the spacing, and with steps of 1 ms", "[validation][sim][long]") {
    // Bounds see above; half the spacing settles faster, its lattice falls by half as much. Among 8000 particles the fastest reaches 4 %,
    // the densest 3 % for a moment.
    for (const double spacing : {d / 2, d}) {
        INFO("spacing " << spacing);
        const Rest rest =
            settle(open_box, "[false, false, false]", {0.1, 0.1, 0.1}, "", spacing, spacing < d ? 1.2 : 2.0, spacing < d ? 5e-3 : 1e-3);
        CAPTURE(rest.early, rest.late, rest.fastest, rest.density, rest.densest);
        CHECK(rest.fastest < 0.05);
        CHECK(rest.late < 0.02 / 3);
        CHECK(rest.late < rest.early / 2);
        CHECK(rest.density < 1e-3);
        CHECK(rest.densest < 5e-2);
    }
}

TEST_CASE(
    "water at rest has the pressure of the depth, within 1 % in the mean over the lower half of a column, within 2.5 % in a slot 6 "
    "spacings wide",
    "[validation][sim][regression]") {
    // The depth below the level that the settled water has (0.5 % lower than the lattice), over 0.3 s. Single layers scatter by 2 %: what
    // the particles of a settled packing press with is not the same in all directions, and the pressure is the mean over them. In the slot
    // two of three particles are next to a wall: 2.0 to 2.2 % (1 % was aimed at).
    for (const bool between_walls : {false, true}) {
        constexpr double layers = 20, H = 0.2, spacing = H / layers, width = 6 * spacing;
        const double reach = between_walls ? 0.05 : 0;
        const std::string walls = fmt::format(
            "[[solid]]\nshape = \"plane\"\nnormal = [1, 0, 0]\n[[solid]]\nshape = \"plane\"\nposition = [{}, 0, 0]\nnormal = [-1, 0, 0]\n",
            width);
        Simulation simulation =
            simulation_of(fmt::format("[time]\nend = 2\nmax_step = 5e-3\n[domain]\nmin = [{0}, -0.05, 0]\nmax = [{1}, 0.3, {2}]\nperiodic "
                                      "= [{3}, false, true]\n[fluid]\nspacing = {4}\n"
                                      "[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [{2}, 0.2, {2}]\n[[solid]]\nshape = "
                                      "\"plane\"\n{5}[models]\npressure = \"ppe\"\n",
                                      -reach, width + reach, width, between_walls ? "false" : "true", spacing, between_walls ? walls : ""));
        run_until(simulation, 0.8);
        double pressure = 0, exact = 0;
        for (int frame = 1; frame <= 30; ++frame) {  // pressures are known at frame times
            run_until(simulation, 0.8 + 0.01 * frame);
            const auto x = simulation.world().fluid.column<field::position>();
            const auto p = simulation.world().fluid.column<field::pressure>();
            double level = 0;
            for (const Vec3& one : x) level += 2 * static_cast<double>(one.y()) / static_cast<double>(x.size());
            for (std::size_t i = 0; i < x.size(); ++i)
                if (x[i].y() < Real(level / 2)) pressure += p[i], exact += rho_0 * g * (level - static_cast<double>(x[i].y()));
        }
        INFO((between_walls ? "slot" : "column"));
        CHECK(pressure / exact == Approx(1).epsilon(between_walls ? 0.025 : 0.01));
    }
}

TEST_CASE(
    "the pressure in water at rest is right at every step, within 5 % in the mean over a quarter of a second, at the default step and at "
    "half of it",
    "[validation][sim]") {
    // The compression by gravity in a step is far less than the density error that a step may leave: a solve that stops there lets the
    // column fall for some steps and catches it in one. Measured: 1.8 % and 1.9 % (12 and 22 % where the solve looked at the density error
    // alone). Mean over the lowest four layers.
    for (const double cfl : {0.4, 0.2}) {
        const Scene scene = read_scene_text(fmt::format(R"toml([time]
end = 1
cfl = {}
[domain]
min = [-0.05, -0.05, -0.05]
max = [0.15, 0.4, 0.15]
[fluid]
spacing = 0.0125
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [0.1, 0.2, 0.1]
[[solid]]
shape = "box"
container = true
min = [0, 0, 0]
max = [0.1, 0.4, 0.1]
)toml",
                                                        cfl),
                                            "column.toml");
        Simulation simulation(scene, make_plan(scene));
        run_until(simulation, 0.5);
        double off = 0;
        int steps = 0;
        for (; simulation.time() < 0.75; ++steps) {
            REQUIRE_FALSE(simulation.step(0.75).diverged);
            const auto x = simulation.world().fluid.column<field::position>();
            const auto p = simulation.world().fluid.column<field::constraint_pressure>();
            double sum = 0, exact = 0;
            for (std::size_t i = 0; i < x.size(); ++i)
                if (x[i].y() < 0.05) sum += p[i], exact += rho_0 * g * (0.2 - x[i].y());
            off += std::abs(sum / exact - 1);
        }
        INFO("cfl " << cfl << ": " << off / steps);
        CHECK(off / steps < 0.05);
        CHECK(simulation.totals().unconverged_solves == 0);
    }
}

namespace {

/// Honey in a bucket of 48 mm that spins at 14/s from the first step on.
std::string spun_bucket(double spacing, double viscosity, const std::string& models = "pressure = \"ppe\"\nviscosity = \"full\"") {
    return fmt::format(R"toml([time]
end = 20
[domain]
min = [-0.06, -0.01, -0.06]
max = [0.06, 0.12, 0.06]
[fluid]
spacing = {}
viscosity = {}
[models]
{}
[[block]]
shape = "cylinder"
from = [0, 0, 0]
to = [0, 0.036, 0]
radius = 0.048
[[solid]]
shape = "cylinder"
from = [0, 0, 0]
to = [0, 0.11, 0]
radius = 0.048
container = true
rotation = [0, 14, 0]
)toml",
                       spacing, viscosity, models);
}

double energy_of(const Simulation& simulation) {
    const Measures now = measure(simulation.world(), Vec3d(0, -g, 0), 1);
    return now.kinetic_energy + now.potential_energy;
}

/// Rigid rotation: z(r) = lowest + omega^2 r^2/(2 g). Its energy within `tolerance`, its surface at the highest particle within `margin`
/// [m].
void check_paraboloid(const Simulation& simulation, double spacing, double tolerance, double margin) {
    constexpr double R = 0.048, omega = 14;
    // Integrals over z, with the volume that the particles have.
    const double k = omega * omega / (2 * g),
                 level = measure(simulation.world(), Vec3d(0, -g, 0), 1).particles * std::pow(spacing, 3) / (std::numbers::pi * R * R),
                 lowest = level - k * R * R / 2,
                 kinetic = rho_0 * omega * omega * std::numbers::pi * (lowest * std::pow(R, 4) / 4 + k * std::pow(R, 6) / 6),
                 potential = rho_0 * g * std::numbers::pi *
                             (lowest * lowest * R * R + lowest * k * std::pow(R, 4) + k * k * std::pow(R, 6) / 3) / 2;
    CHECK(energy_of(simulation) == Approx(kinetic + potential).epsilon(tolerance));
    Vec3 highest = Vec3::Zero();
    for (const Vec3& x : simulation.world().fluid.column<field::position>())
        if (x.y() > highest.y()) highest = x;
    const double r = std::hypot(highest.x(), highest.z());
    CHECK(highest.y() + spacing / 2 == Approx(lowest + k * r * r).margin(margin));
}

}  // namespace

TEST_CASE("a bucket of honey that spins keeps the paraboloid and its energy", "[pressure][boundary]") {
    // The packing gives way slowly: at 3 s the energy is 1.5 % below the exact one.
    constexpr double spacing = 8e-3;
    Simulation simulation = simulation_of(spun_bucket(spacing, 4));
    simulation.count_energy();
    run_until(simulation, 2);
    const double before = energy_of(simulation);
    run_until(simulation, 3);
    const double now = energy_of(simulation);
    check_paraboloid(simulation, spacing, 0.02, spacing / 2);
    CHECK(now == Approx(before).epsilon(0.005));
    CHECK(std::abs(simulation.totals().work.error(now)) < 0.01 * now);
    CHECK(measure(simulation.world(), Vec3d(0, -g, 0), 1).density_error_mean < 1e-3);
}

TEST_CASE("coupled honey in a bucket that spins keeps the paraboloid within half a spacing, its energy within 1.5 %",
          "[coupled][boundary]") {
    // 6 spacings in the radius. If the force of the fluid's own hydrostatic pressure erred among disordered particles: 3.8 % high, 2
    // spacings too high at 20/s. If walls had the next step's velocities in the gradients before the solve: 6 %.
    constexpr double spacing = 8e-3;
    Simulation simulation = simulation_of(spun_bucket(spacing, 4, "pressure = \"coupled\""));
    run_until(simulation, 3);
    check_paraboloid(simulation, spacing, 0.015, spacing / 2);
}

TEST_CASE("honey spun for 20 s keeps its energy from 2 s on: within .5 % under ppe, 1 % under coupled",
          "[pressure][coupled][boundary][long]") {
    for (const bool coupled : {false, true}) {
        CAPTURE(coupled);
        const double spacing = coupled ? 8e-3 : 6e-3;
        Simulation simulation = simulation_of(coupled ? spun_bucket(spacing, 4, "pressure = \"coupled\"") : spun_bucket(spacing, 4));
        run_until(simulation, 2);
        const double before = energy_of(simulation);
        run_until(simulation, 20);
        check_paraboloid(simulation, spacing, 0.03, coupled ? spacing : spacing / 2);
        CHECK(energy_of(simulation) == Approx(before).epsilon(coupled ? 0.01 : 0.005));
    }
}

TEST_CASE("honey of 50 Pa s does not climb a bucket that spins, and its energy in that frame falls", "[pressure][boundary]") {
    // With walls that move along straight lines in a step, it falls until 1 s and then rises.
    Simulation simulation = simulation_of(spun_bucket(8e-3, 50));
    simulation.count_energy();
    run_until(simulation, 0.1);  // the lattice next to the round wall has been separated
    const double moved = simulation.totals().work.moves;
    double last = std::numeric_limits<double>::infinity();
    for (int k = 1; k <= 6; ++k) {
        run_until(simulation, 0.3 * k);
        const Measures now = measure(simulation.world(), Vec3d(0, -g, 0), 1);
        const double energy = now.kinetic_energy + now.potential_energy - 14 * now.angular_momentum.y();
        CHECK(energy < last);
        CHECK(simulation.totals().work.moves < moved + 1e-5 * now.potential_energy);
        last = energy;
    }
}

}  // namespace at_rest_test

/// Fluid at rest between the solids of a scene: read, plan, simulate.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cmath>

#include "engine/models/boundary/wall.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"

using namespace whorl;

namespace {

constexpr double d = 0.01, g = 9.81, rho_0 = 1000;

void run_until(Simulation& simulation, double end) {
    while (simulation.time() < end) REQUIRE_FALSE(simulation.step(end).diverged);
}

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
{})toml", spacing, sampling, rest), "water.toml");
}

}  // namespace

TEST_CASE("weakly compressible water comes to rest in an open box and in a full slot, with the pressure of its weight within 2 %", "[validation][sim]") {
    // At two spacings, from a lattice (which melts within a second) and from an irregular start. It is the difference of pressure between the
    // lowest and the middle third that is held against the weight between them: the slot has no surface that could set the pressure to zero, and
    // at the surface of the box the topmost layer, whose kernel sums fall short, carries none.
    const std::string box = R"toml([domain]
min = [-0.05, -0.05, -0.05]
max = [0.11, 0.2, 0.11]
[[solid]]
shape = "box"
inside = true
min = [0, 0, 0]
max = [0.06, 0.2, 0.06]
)toml", slot = R"toml([domain]
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
    for (const std::string& solids : {box, slot})
        for (const double spacing : {0.01, 0.0075})
            for (const std::string sampling : {"lattice", "blue_noise"}) {
                INFO((solids == box ? "box" : "slot") << ", spacing " << spacing << ", " << sampling);
                const Scene scene = water(solids, spacing, sampling);
                Simulation simulation(scene, make_plan(scene));
                run_until(simulation, 1.0);
                double difference = 0, exact = 0, fastest = 0;
                while (simulation.time() < 1.2) {
                    REQUIRE_FALSE(simulation.step(1.2).diverged);
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
}

TEST_CASE("a scene's column of 30 layers on a plane presses on it with its weight within 2 %, with both pressure models", "[validation][sim]") {
    // Periodic sideways; the particles of the plane are what sample_solids makes of it. Mean over 0.2 s after 1.0 s of settling.
    const std::string smoothed = "viscosity = \"xsph\"\n[viscosity]\nalpha = 0.05\n";  // wcsph has dampers of its own
    for (const std::string pressure : {"ppe", "wcsph"}) {
        INFO(pressure);
        const Scene scene = read_scene_text(R"toml([time]
end = 1.2
max_step = 2e-3
[domain]
min = [0, -0.05, 0]
max = [0.06, 0.4, 0.06]
periodic = [true, false, true]
[fluid]
spacing = 0.01
[[block]]
shape = "box"
min = [0, 0, 0]
max = [0.06, 0.3, 0.06]
[[solid]]
shape = "plane"
[models]
pressure = ")toml" + pressure + "\"\n" + (pressure == "ppe" ? smoothed : ""), "column.toml");
        Simulation simulation(scene, make_plan(scene));
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

TEST_CASE("water that fills the slot between a floor and a ceiling stays at rest, with a pressure 2 % too flat", "[validation][sim]") {
    // Too flat by what the kernel makes of a linear pressure on a lattice with R = 2 d: its gradient is 1.02 times too steep. Within 1 % of that.
    // No free surface: the pressure has no natural zero. The ceiling must mirror the pressure less the weight up to it, or the topmost layer falls
    // (the run diverged within 0.2 s). Held until the lattice, which is no stable packing, starts to melt (0.3 s).
    const Scene scene = read_scene_text(R"toml([time]
end = 0.2
max_step = 2e-3
[domain]
min = [0, -0.05, 0]
max = [0.1, 0.15, 0.1]
periodic = [true, false, true]
[fluid]
spacing = 0.01
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [0.1, 0.1, 0.1]
[[solid]]
shape = "plane"
[[solid]]
shape = "plane"
position = [0, 0.1, 0]
normal = [0, -1, 0]
)toml", "slot.toml");
    Simulation simulation(scene, make_plan(scene));
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
    const double steepness = lattice_second_moment(KernelKind::cubic, Real(2 * d), Real(d)) / 3;
    CHECK((low - high) / steps * steepness == Approx(rho_0 * g * 9 * d).epsilon(0.01));
}

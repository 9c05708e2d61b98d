/// A whole coil: emission, fall, contact, probe, against slender-thread theory.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/probes/probes.h"
#include "engine/scene/read.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

struct CoilCase {
    double speed, fall, nu;    ///< m/s, m, m^2/s
    double frequency, radius;  ///< Hz, m: slender-thread theory (Ribe 2004) for a nozzle of 5 mm radius
};

/// A thread that coils on a plate. A drain removes fluid after 0.6 of a turn, so that no heap shortens the fall. The plate circles like the
/// coil until the thread has been down for 1.5 turns; otherwise the thread first folds for some turns.
Scene coil_on_plate(const CoilCase& c, double spacing, double turns) {
    const std::string circle = fmt::format("{}*max(0, min(1, ({}-t)*{}))", c.radius, c.fall / c.speed + 1.5 / c.frequency, c.frequency);
    const double pi2 = 2 * std::numbers::pi;
    const std::string text =
        text::time(c.fall / c.speed + turns / c.frequency) + text::domain({-0.12, -0.02, -0.12}, {0.12, 0.22, 0.12}) +
        text::fluid(spacing, 1000 * c.nu) + text::models("coupled") + text::emitter({0, c.fall, 0}, 5e-3, c.speed) +
        "[[solid]]\nshape = \"cylinder\"\nfrom = [0, -0.01, 0]\nto = [0, 0, 0]\nradius = 0.1\n" +
        fmt::format("position = [\"{0}*cos({1}*t)\", \"0\", \"{0}*sin({1}*t)\"]\n", circle, pi2 * c.frequency) +
        fmt::format("[[drain]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, 0.012, 0]\nradius = 0.12\ndelay = {}\n",
                    0.6 / c.frequency) +
        "[[probe]]\nname = \"coil\"\nkind = \"coil\"\n";
    return read_scene_text(text, "coil.toml");
}

/// 2.5 particles across the nozzle's radius; the probe's own uncertainty after seven turns is 1 to 2 %. The same at finer spacings:
/// docs/reports/coils.md. @param off largest deviation from the theory's frequency, relative
void turns_as_theory_says(const CoilCase& c, double off) {
    INFO(c.speed << " m/s from " << c.fall << " m, " << c.nu << " m^2/s");
    const Scene scene = coil_on_plate(c, 2e-3, 7);
    Simulation simulation(scene, make_plan(scene));
    const auto probe = make_probe(scene.probes.at(0), simulation.world());
    run_until(simulation, scene.time.end, [&] { probe->after_step(simulation.world(), simulation.time()); });
    CHECK(simulation.totals().lost_particles == 0);
    // time, frequency, radius, turns, spreads, pile_height, uncertainties, fall
    const std::vector<double> row = rows_of(*probe, simulation).front();
    REQUIRE(row.size() >= 10);
    CHECK(row[1] == Approx(c.frequency).epsilon(off));
    CHECK(row[2] == Approx(c.radius).epsilon(0.15));
    CHECK(row[3] > 4);
    CHECK(row[9] == Approx(c.fall).epsilon(0.03));  // no heap
}

}  // namespace

TEST_CASE("a thin coil has the frequency of slender-thread theory within 10 %, its radius within 15 %", "[validation][coil]") {
    turns_as_theory_says({0.25, 0.12, 0.05, 5.48, 0.011502}, 0.1);
}

TEST_CASE("viscous and inertio-gravitational coils match theory's frequency within 10 %, radius within 15 %", "[validation][coil][long]") {
    turns_as_theory_says({0.25, 0.08, 1.0, 2.139, 0.017737}, 0.1);
    turns_as_theory_says({0.1, 0.12, 0.2, 1.5221, 0.016686}, 0.1);
}

TEST_CASE("a thread a quarter as thick as its coil turns within 14 % of slender-thread theory", "[validation][coil][long][regression]") {
    turns_as_theory_says({0.25, 0.08, 0.05, 3.371, 0.013175}, 0.14);
}

/// Fluid at rest sleeps: it costs nothing, stays where it is, and wakes in time.
#include "engine/sim/sleep.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "engine/core/parallel.h"
#include "engine/io/diagnostics.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"

using namespace whorl;

namespace {

/// A puddle of syrup in its box, onto which more is poured after 1.1 s.
std::string puddle(const std::string& pressure, double sleep) {
    return "[time]\nend = 3\nsleep = " + std::to_string(sleep) + "\n[domain]\nmin = [-0.05, -0.05, -0.05]\nmax = [0.25, 0.3, 0.15]\n"
           "[fluid]\nspacing = 0.01\nviscosity = 30\n[models]\npressure = \"" + pressure + "\"\n[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.2, 0.05, 0.1]\n"
           "[[emitter]]\nposition = [0.04, 0.12, 0.05]\nradius = 0.015\nspeed = 0.3\nstart = 1.1\n"
           "[[solid]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.2, 0.28, 0.1]\ninside = true\n";
}

struct Pool {
    Simulation simulation;
    explicit Pool(const std::string& text)
        : simulation([&] {
              const Scene scene = read_scene_text(text, "puddle.toml");
              return Simulation(scene, make_plan(scene));
          }()) {}
    void run_until(double end) {
        for (int frame = static_cast<int>(std::lround(24 * simulation.time())) + 1; frame <= std::lround(24 * end); ++frame)
            while (simulation.time() < frame / 24.0) REQUIRE_FALSE(simulation.step(frame / 24.0).diverged);
    }
    Measures measures() const { return measure(simulation.world(), Vec3d(0, -9.81, 0), 0); }
};

std::string state_of(const Simulation& simulation) {
    std::ostringstream out;
    simulation.save(out);
    return out.str();
}

}  // namespace

TEST_CASE("a settled puddle falls asleep, is not solved for, and keeps its height; what is poured onto it wakes it in time", "[sleep]") {
    // Honey creeps to rest; with the pressure equation particles go on milling about by less than a spacing, which is what has to count as rest there.
    for (const auto& [pressure, rest] : {std::pair<std::string, double>{"coupled", 0.05}, {"ppe", 1.0}}) {
        INFO(pressure);
        Pool awake(puddle(pressure, 0)), sleepy(puddle(pressure, rest));
        awake.run_until(1), sleepy.run_until(1);
        const Index all = awake.simulation.world().fluid.size();
        CHECK(sleepy.simulation.world().fluid.size() == all);
        const Measures a = awake.measures(), s = sleepy.measures();
        // Resting, both: what sleep keeps from moving is less than a twentieth of a spacing of height (m g d/20).
        CHECK(s.potential_energy == Approx(a.potential_energy).margin(0.05 * 0.01 * 9.81 * 1e-3 * static_cast<double>(all)));
        // The puddle is put away but for the nozzle's fluid.
        const double before = sleepy.simulation.totals().particle_steps;
        const long steps = sleepy.simulation.totals().steps;
        sleepy.run_until(1 + 1 / 24.0);
        const double in_store = (sleepy.simulation.totals().particle_steps - before) / static_cast<double>(sleepy.simulation.totals().steps - steps);
        CHECK(in_store < 0.2 * static_cast<double>(all));
        // Then more is poured in: the puddle moves where it lands, no particle is lost, and both end at the same height and as dense.
        awake.run_until(1.75), sleepy.run_until(1.75);
        CHECK(sleepy.simulation.world().fluid.size() == awake.simulation.world().fluid.size());
        CHECK(sleepy.measures().potential_energy == Approx(awake.measures().potential_energy).margin(0.1 * 0.01 * 9.81 * 1e-3 * static_cast<double>(all)));
        CHECK(sleepy.measures().density_error_max < awake.measures().density_error_max + 0.1);
    }
}

TEST_CASE("a run that sleeps is the same for any number of threads and after a resume", "[sleep]") {
    const std::string text = puddle("ppe", 1);
    set_threads(1);
    Pool whole(text), half(text);
    whole.run_until(1.25);
    half.run_until(1);
    set_threads(2);
    Pool other(text);
    std::istringstream in(state_of(half.simulation));
    other.simulation.load(in);
    other.run_until(1.25);
    CHECK(state_of(whole.simulation) == state_of(other.simulation));
    set_threads(0);
}

TEST_CASE("what sleep cannot go with is refused", "[sleep]") {
    const Scene scene = read_scene_text(puddle("ppe", 0.05) + "[[drain]]\nshape = \"sphere\"\nradius = 0.01\n", "puddle.toml");
    CHECK_THROWS_WITH(make_plan(scene), Catch::Contains("time.sleep puts away fluid that a drain has to see at every step"));
}

#pragma once
/// A puddle at rest, and what pours onto it: for tests of sleep.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "engine/io/diagnostics.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"

namespace whorl::test {

/// A puddle of syrup in its box, onto which more is poured from `start` [s] on. @param length of the box [m]: 100 particles a spacing
inline std::string puddle(const std::string& pressure, double sleep, double length, double start) {
    const std::string x = std::to_string(length);
    return "[time]\nend = 3\nsleep = " + std::to_string(sleep) +
           "\n[domain]\nmin = [-0.05, -0.05, -0.05]\nmax = [0.25, 0.3, 0.15]\n"
           "[fluid]\nspacing = 0.01\nviscosity = 30\n[models]\npressure = \"" +
           pressure + "\"\n[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [" + x +
           ", 0.05, 0.1]\n"
           "[[emitter]]\nposition = [0.03, 0.12, 0.05]\nradius = 0.015\nspeed = 0.3\nstart = " +
           std::to_string(start) +
           "\n"
           "[[solid]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [" +
           x + ", 0.28, 0.1]\ninside = true\n";
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
    Index size() const { return simulation.world().fluid.size(); }
    /// Particles that a step has to do with, in the frame after now.
    double solved_for() {
        const double before = simulation.totals().particle_steps;
        const long steps = simulation.totals().steps;
        run_until(simulation.time() + 1 / 24.0);
        return (simulation.totals().particle_steps - before) / static_cast<double>(simulation.totals().steps - steps);
    }
};

}  // namespace whorl::test

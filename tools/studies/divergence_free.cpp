/// What a velocity that is free of divergence keeps, beside the constraint alone (docs/pressure.md).
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "engine/core/clock.h"
#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/io/diagnostics.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "tools/studies/studies.h"
#include "tools/studies/zeros.h"

namespace whorl {
namespace {

/// A run of a scene's text with the constraint, with or without divergence_free.
struct Run {
    Simulation simulation;
    double start_cpu = cpu_seconds(), density_error = 0;
    long steps = 0;
    static Simulation simulation_of(const std::string& text, bool divergence_free, const std::string& keys) {
        const Scene scene = read_scene_text(text + "[pressure]\ndivergence_free = " + (divergence_free ? "true\n" : "false\n") + keys,
                                            "divergence_free.toml");
        return Simulation(scene, make_plan(scene));
    }
    /// @param keys more of the table [pressure]
    Run(const std::string& text, bool divergence_free, const std::string& keys = "")
        : simulation(simulation_of(text, divergence_free, keys)) {}
    Measures now() const { return measure(simulation.world(), simulation.world().step.gravity.cast<double>(), 1); }
    void step(double end) {
        if (const auto diverged = simulation.step(end).diverged)
            throw EnvironmentError("a run of the study diverged: " + diverged->what, "", "");
        density_error += now().density_error_mean;
        ++steps;
    }
    void until(double end) {
        while (simulation.time() < end) step(end);
    }
    /// CPU us a particle-step, mean density error in per cent.
    std::string cost() const {
        return fmt::format("{:.2g} | {:.1f}", 100 * density_error / static_cast<double>(steps),
                           1e6 * (cpu_seconds() - start_cpu) / static_cast<double>(simulation.totals().particle_steps));
    }
};

std::string vortex(const std::string& sampling) {
    return R"toml([time]
end = 1
[domain]
min = [0, 0, 0]
max = [1, 1, 1]
periodic = [true, true, true]
gravity = [0, 0, 0]
[fluid]
spacing = 0.0625
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [1, 1, 1]
velocity = ["sin(2*pi*x)*cos(2*pi*y)*cos(2*pi*z)", "-cos(2*pi*x)*sin(2*pi*y)*cos(2*pi*z)", "0"]
sampling = ")toml" +
           sampling + "\"\n";
}

std::string energy_left(const std::string& text, double end, bool divergence_free) {
    Run run(text, divergence_free);
    const double start = run.now().kinetic_energy;
    run.until(end);
    return fmt::format("{:.1f} % of the energy left | {}", 100 * run.now().kinetic_energy / start, run.cost());
}

/// The scene rotating_drop, as water and as syrup: a rod, thrown like a baton.
std::string rod(double viscosity) {
    return fmt::format(R"toml([time]
end = 2
[domain]
min = [-0.4, -0.4, -0.4]
max = [0.4, 0.4, 0.4]
gravity = [0, 0, 0]
[fluid]
spacing = 4e-3
viscosity = {}
[models]
pressure = "ppe"
viscosity = "{}"
[[block]]
shape = "cylinder"
from = [-0.045, 0, 0]
to = [0.045, 0, 0]
radius = 0.022
velocity = ["-6*y", "6*x", "0"]
sampling = "blue_noise"
)toml",
                       viscosity, viscosity > 0 ? "full" : "none");
}

std::string drop(double viscosity, double end, bool divergence_free) {
    Run run(rod(viscosity), divergence_free);
    const Measures start = run.now();
    run.until(end);
    const Measures now = run.now();
    return fmt::format("{:.1f} % of the energy, {:.2f} % of the angular momentum left | {}",
                       100 * now.kinetic_energy / start.kinetic_energy, 100 * now.angular_momentum.z() / start.angular_momentum.z(),
                       run.cost());
}

std::string column(bool divergence_free) {
    Run run(R"toml([time]
end = 2
max_step = 5e-3
[domain]
min = [0, -0.05, 0]
max = [0.1, 0.4, 0.1]
periodic = [true, false, true]
[fluid]
spacing = 0.0125
[models]
pressure = "ppe"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [0.1, 0.25, 0.1]
[[solid]]
shape = "plane"
)toml",
            divergence_free);
    const Measures start = run.now();
    run.until(1.5);
    const Measures now = run.now();
    return fmt::format("{:.1e} J of motion, {:.2f} % of the height lost | {}", now.kinetic_energy,
                       100 * (1 - now.potential_energy / start.potential_energy), run.cost());
}

/// The standing wave of tests/validation/sim/waves.cpp, on a lattice.
std::string wave(double damping, bool divergence_free) {
    constexpr double length = 0.4, h = 0.2, U = 0.1, d = 0.01, k = 2 * std::numbers::pi / length;
    Run run(fmt::format(R"toml([time]
end = 2
max_step = 5e-3
[domain]
min = [0, -0.05, 0]
max = [{0}, 0.4, 0.06]
periodic = [true, false, true]
[fluid]
spacing = {1}
[[block]]
shape = "box"
min = [0, 0, 0]
max = [{0}, {2}, 0.06]
velocity = ["{3}*sin({4}*x)*cosh({4}*y)", "-{3}*cos({4}*x)*sinh({4}*y)", "0"]
[[solid]]
shape = "plane"
[models]
pressure = "ppe"
)toml",
                        length, d, h, U / std::sinh(k * h), k),
            divergence_free, fmt::format("damping = {}\n", damping));
    const double period = 2 * std::numbers::pi / std::sqrt(9.81 * k * std::tanh(k * h));
    Zeros zeros(period / 4);
    while (zeros.at.size() < 6 && run.simulation.time() < 2) {
        run.step(2);
        const auto x = run.simulation.world().fluid.column<field::position>();
        const auto u = run.simulation.world().fluid.column<field::velocity>();
        double now = 0;
        for (std::size_t i = 0; i < x.size(); ++i) now += static_cast<double>(u[i].y()) * std::cos(k * static_cast<double>(x[i].x()));
        zeros.sample(run.simulation.time(), now);
    }
    if (zeros.at.size() < 6) return "no five half periods | " + run.cost();
    return fmt::format("period {:.3f} of theory's | {}", (zeros.at[5] - zeros.at[0]) / 2.5 / period, run.cost());
}

}  // namespace

std::string divergence_free_table() {
    set_threads(1);
    std::string table =
        "| case | constraint | mean density error % | CPU us a particle-step | divergence-free | mean density error % | CPU us a "
        "particle-step |\n|---|---|---|---|---|---|---|\n";
    const auto row = [&](const std::string& name, const auto& measured) {
        table += "| " + name + " | " + measured(false) + " | " + measured(true) + " |\n";
    };
    row("Taylor-Green, scattered, 0.3 s", [](bool free) { return energy_left(vortex("blue_noise"), 0.3, free); });
    row("Taylor-Green, lattice, 0.3 s", [](bool free) { return energy_left(vortex("lattice"), 0.3, free); });
    row("column of 20 layers, 1.5 s", column);
    row("standing wave", [](bool free) { return wave(2, free); });
    row("standing wave, damping = 0", [](bool free) { return wave(0, free); });
    row("rotating_drop without viscosity, a radian", [](bool free) { return drop(0, 1.0 / 6, free); });
    row("rotating_drop, 60 Pa s, two turns", [](bool free) { return drop(60, 2.1, free); });
    set_threads(0);
    return table;
}

}  // namespace whorl

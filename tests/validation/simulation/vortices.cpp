/// Vortices of the projection against exact solutions, a spectral method and a grid.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/benchmarks.h"
#include "tests/support/micropolar_flows.h"
#include "tests/support/runs.h"

using namespace whorl;
using namespace whorl::test;

namespace vortices_test {

namespace {

constexpr double pi = std::numbers::pi;

/// Taylor-Green vortices as a scene has them. @param amplitude "exp(-t)" @param depth a third component, where there is one
std::string vortices_of(const std::string& amplitude, const std::string& depth = "") {
    return fmt::format(R"toml(["{0}*sin(2*pi*x)*cos(2*pi*y)", "-{0}*cos(2*pi*x)*sin(2*pi*y)"{1}])toml", amplitude, depth);
}
std::string decay(double nu) { return fmt::format("exp(-{}*t)", 8 * pi * pi * nu); }

/// Runs the scene and compares the energy and the velocity of each particle with the exact flow at several times. @param energy, velocity
/// relative bounds
void hold_to_theory(const std::vector<std::string>& changes, double energy, double velocity, double end = 2) {
    Simulation simulation = benchmark("taylor_green_vortices", changes);
    for (double time = 0.5; time <= end; time += 0.5) {
        run_until(simulation, time);
        const Table flow = reading(simulation, "flow");
        INFO("t = " << time);
        CHECK(flow.at("kinetic_energy")[0] == Approx(flow.at("expected_energy")[0]).epsilon(energy));
        CHECK(flow.at("velocity_error")[0] < velocity);
    }
}

std::vector<std::string> taylor_green(int a_side, int reynolds, const std::string& sampling) {
    const double nu = 1.0 / reynolds;
    return {fmt::format("fluid.spacing={}", 1.0 / a_side), fmt::format("fluid.viscosity={}", 1000 * nu), "block.0.sampling=" + sampling,
            "probe.0.expected=" + vortices_of(decay(nu))};
}

}  // namespace

// At 32 a side the operators themselves are off by .8 % (their error falls with the square of the spacing: .2 % at 64).
TEST_CASE("Taylor-Green vortices, 32 a side, keep energy and velocity within 1.5 and 2 % of theory", "[validation][projection]") {
    hold_to_theory(taylor_green(32, 100, "lattice"), 0.015, 0.02, 1);
    hold_to_theory(taylor_green(32, 1000, "jittered"), 0.015, 0.02, 1);
}

TEST_CASE("Taylor-Green vortices, 64 a side, keep energy and velocity within .5 % of theory", "[validation][projection][long]") {
    for (const int reynolds : {100, 1000})
        for (const char* sampling : {"lattice", "jittered"}) hold_to_theory(taylor_green(64, reynolds, sampling), 0.005, 0.005);
}

namespace {

/// Energy over theory at .25 s after `steps` equal steps, 32 a side, jittered.
double energy_after_steps(int reynolds, int steps) {
    std::vector<std::string> changes = taylor_green(32, reynolds, "jittered");
    changes.insert(changes.end(), {fmt::format("time.max_step={}", 0.25 / steps), "time.cfl=2", "time.fps=4", "time.end=0.25"});
    Simulation simulation = benchmark("taylor_green_vortices", changes);
    run_until(simulation, 0.25);
    const Table flow = reading(simulation, "flow");
    return flow.at("kinetic_energy")[0] / flow.at("expected_energy")[0];
}

}  // namespace

TEST_CASE("Taylor-Green vortices converge with the step's square", "[validation][projection]") {
    for (const int reynolds : {100, 1000}) {
        // At Re 100 viscosity allows no step longer than a tenth of this time; the default takes 36.
        std::vector<double> energies;
        for (const int steps : {10, 20, 40, 80}) energies.push_back(energy_after_steps(reynolds, steps));
        const double coarse = std::abs(energies[1] - energies[0]), fine = std::abs(energies[3] - energies[2]);
        INFO("Re " << reynolds << ", energies over theory " << energies[0] << ", " << energies[1] << ", " << energies[2] << ", "
                   << energies[3]);
        CHECK(std::log2(coarse / fine) / 2 == Approx(2).margin(0.3));  // the packing's disorder differs from run to run
    }
}

TEST_CASE("Taylor-Green vortices converge with the spacing at second order or better", "[validation][projection]") {
    for (const int reynolds : {100, 1000}) {
        std::vector<double> errors;
        for (const int a_side : {16, 32}) {
            Simulation simulation = benchmark("taylor_green_vortices", taylor_green(a_side, reynolds, "jittered"));
            run_until(simulation, 1);
            errors.push_back(reading(simulation, "flow").at("velocity_error")[0]);
        }
        INFO("Re " << reynolds << ": errors " << errors[0] << ", " << errors[1]);
        CHECK(std::log2(errors[0] / errors[1]) > 1.8);
    }
}

TEST_CASE("Taylor-Green vortices in a slab of eight layers keep energy and velocity within 2 % of theory",
          "[validation][projection][long]") {
    for (const char* sampling : {"lattice", "jittered"}) {
        INFO(sampling);
        hold_to_theory(
            {"domain.dimensions=3", "domain.min=[0,0,0]", "domain.max=[1,1,0.25]", "domain.periodic=[true,true,true]",
             "domain.gravity=[0,0,0]", "block.0.min=[0,0,0]", "block.0.max=[1,1,0.25]", "block.0.velocity=" + vortices_of("1", R"(, "0")"),
             std::string("block.0.sampling=") + sampling, "probe.0.min=[0,0,0]", "probe.0.max=[1,1,0.25]", "probe.1.min=[0,0,0]",
             "probe.1.max=[0.5,0.5,0.25]", "probe.0.expected=" + vortices_of(decay(0.01), R"(, "0")")},
            0.02, 0.02);
    }
}

TEST_CASE("Taylor-Green vortices with spin keep energy within 2 % and spin within 3 % of their equations",
          "[validation][projection][micropolar]") {
    // U' = -2 a k^2 U + kappa k W, theta W' = -2 g k^2 W + kappa (2 k U - 2 W), from U = 1, W = 0. The spin's mean over a cell is
    // (2/pi)^2 W.
    const Micropolar2 c{.a = 0.0125, .kappa = 0.005, .g = 1e-4, .theta = 1e-3};
    Simulation simulation =
        benchmark("taylor_green_vortices",
                  {"models.micropolar=bender", "fluid.viscosity=12.5", "micropolar.transfer_viscosity=5", "micropolar.spin_viscosity=0.1",
                   "micropolar.micro_inertia=1e-3", "micropolar.xsph_velocity=0", "micropolar.xsph_spin=0"});
    const double start = reading(simulation, "flow").at("kinetic_energy")[0];
    for (const double time : {0.25, 0.5}) {
        run_until(simulation, time);
        const auto [U, W] = exact_vortex(c, time, 2 * pi);
        INFO("t = " << time);
        CHECK(reading(simulation, "flow").at("kinetic_energy")[0] == Approx(start * U * U).epsilon(0.02));
        CHECK(reading(simulation, "cell").at("spin_z")[0] == Approx(4 / (pi * pi) * W).epsilon(0.03));
    }
}

TEST_CASE("a Lamb-Oseen vortex core grows within 1.5 % of theory at a spacing of a third of the core", "[validation][projection]") {
    // The vorticity is a sum of modes sin(m pi x) sin(n pi y), m and n odd, each of which decays as exp(-nu k^2 t): cores stay round and do
    // not move. Energy: sum of exp(-k^2 c^2/2)/k^2.
    const auto energy = [](double square_core) {
        double sum = 0;
        for (int m = 1; m < 60; m += 2)
            for (int n = 1; n < 60; n += 2) {
                const double k2 = pi * pi * (m * m + n * n);
                sum += std::exp(-k2 * square_core / 2) / k2;
            }
        return sum;
    };
    const double nu = 1e-3, first = 0.01;
    Simulation simulation = benchmark("lamb_oseen");
    const double start = reading(simulation, "flow").at("kinetic_energy")[0];
    for (const double time : {0.5, 1.0}) {
        run_until(simulation, time);
        // The radius that fits the particles around one vortex best. (On a line between them the kernel widens the core by 1 %.)
        const auto x = positions(simulation), u = velocities(simulation);
        double best = 0, least = 1e9;
        for (double core = 0.05; core < 0.4; core += 1e-4) {
            double off = 0;
            for (std::size_t k = 0; k < x.size(); ++k) {
                const Vec3d from = x[k].cast<double>() - Vec3d(0.5, 0.5, 0);
                const double r = from.norm();
                if (r > 0.25 || r < 1e-6) continue;
                const double context = (from.x() * static_cast<double>(u[k].y()) - from.y() * static_cast<double>(u[k].x())) / r;
                const double expected = (1 - std::exp(-r * r / (core * core))) / (2 * pi * r);
                off += (context - expected) * (context - expected);
            }
            if (off < least) least = off, best = core;
        }
        const double square = first + 4 * nu * time;
        INFO("t = " << time);
        CHECK(best == Approx(std::sqrt(square)).epsilon(0.015));
        CHECK(reading(simulation, "flow").at("kinetic_energy")[0] == Approx(start * energy(square) / energy(first)).epsilon(0.01));
    }
}

TEST_CASE("the double shear layer keeps energy within .3 % and vorticity within 2 % of a spectral method",
          "[validation][projection][long]") {
    const Table spectral = reference("double_shear_layer");
    Simulation simulation = benchmark("double_shear_layer", {"fluid.spacing=0.015625"});
    const double start = reading(simulation, "flow").at("kinetic_energy")[0];
    for (const double time : {0.5, 0.8, 1.0}) {
        run_until(simulation, time);
        const Table flow = reading(simulation, "flow");
        INFO("t = " << time);
        CHECK(flow.at("kinetic_energy")[0] / start == Approx(between(spectral.at("time"), spectral.at("energy"), time)).epsilon(0.003));
    }
    const double largest = reading(simulation, "flow").at("largest_vorticity")[0];
    CHECK(largest == Approx(spectral.at("largest_vorticity")[10]).epsilon(0.02));
}

namespace {

/// The largest distance of the centre lines' velocities from those of a grid, over the lid's speed.
double cavity_error(int reynolds, int a_side, double end) {
    Simulation simulation =
        benchmark("lid_driven_cavity", {fmt::format("fluid.spacing={}", 1.0 / a_side), fmt::format("fluid.viscosity={}", 1000.0 / reynolds),
                                        fmt::format("time.end={}", end)});
    run_until(simulation, end);
    const Table grid = reference("lid_driven_cavity");
    double largest = 0;
    for (const auto& [probe, column] : {std::pair("u", "velocity_x"), std::pair("v", "velocity_y")}) {
        const Table line = reading(simulation, probe);
        const std::vector<double>& expected = grid.at(fmt::format("{}_{}", probe, reynolds));
        for (std::size_t k = 0; k < expected.size(); ++k) largest = std::max(largest, std::abs(line.at(column)[k] - expected[k]));
    }
    return largest;
}

}  // namespace

// The grid's own error is 2e-4 of the lid's speed (docs/reports/vortices.md).
TEST_CASE("the cavity at Re 100 and 400 is within 2 %, 128 a side 1 % of the lid's speed of a grid's solution",
          "[validation][projection][long]") {
    CHECK(cavity_error(100, 64, 15) < 0.02);
    CHECK(cavity_error(100, 128, 15) < 0.01);
    CHECK(cavity_error(400, 64, 40) < 0.02);
}

// Not reached: 4.6 % (attempts: docs/reports/vortices.md).
TEST_CASE("the cavity at Re 1000, 64 a side, is within 2 % of the lid's speed of a grid's solution", "[validation][projection][long]") {
    CHECK(cavity_error(1000, 64, 60) < 0.02);
}

TEST_CASE("Ghia, Ghia and Shin's cavity velocities are within 2 % of the lid's speed of the grid solution", "[validation]") {
    // Theirs are from 129 points a side. At Re 400 one of them, v at x = .9063, is a misprint: it breaks the curve.
    const Table grid = reference("lid_driven_cavity");
    int compared = 0;
    for (const char* profile : {"u", "v"}) {
        const Table published = reference(std::string("ghia_ghia_shin_1982_") + profile);
        for (const int reynolds : {100, 400, 1000})
            for (std::size_t k = 0; k < published.at("place").size(); ++k) {
                const double place = published.at("place")[k], value = published.at(std::to_string(reynolds))[k];
                if (reynolds == 400 && place == 0.9063) continue;
                INFO("Re " << reynolds << ", " << profile << " at " << place);
                CHECK(value == Approx(between(grid.at("s"), grid.at(fmt::format("{}_{}", profile, reynolds)), place)).margin(0.02));
                ++compared;
            }
    }
    CHECK(compared == 101);
}

}  // namespace vortices_test

#include "engine/theory/coil_theory.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

using namespace whorl;

namespace {

CoilParameters nozzle_of_5_mm(double speed, double fall, double viscosity) { return {5e-3, speed, viscosity, 9.81, fall, 0}; }

CoilTheory found(const CoilParameters& parameters) {
    CoilSolver solver;
    const auto theory = solver.at(parameters);
    REQUIRE(theory);
    CHECK(solver.effort() < CoilSolver::most_effort);
    return *theory;
}

}  // namespace

TEST_CASE("steady coils of every regime match the published frequency and radius within 0.01 %", "[io][coil_theory]") {
    std::ifstream table(WHORL_SOURCE_DIR "/scenes/studies/coil_theory.csv");
    std::string line;
    std::getline(table, line);
    int rows = 0;
    while (std::getline(table, line)) {
        double value[5] = {};
        std::istringstream cells(line);
        std::string cell;
        for (double& v : value) std::getline(cells, cell, ','), v = std::stod(cell);
        INFO(line);
        const CoilTheory theory = found(nozzle_of_5_mm(value[0], value[1], value[2]));
        CHECK(theory.frequency == Approx(value[3]).epsilon(1e-4));
        CHECK(theory.radius == Approx(value[4]).epsilon(1e-4));
        ++rows;
    }
    CHECK(rows == 14);
}

// Speed, fall, viscosity, frequency, radius: from another implementation (scipy's solve_bvp), for settings of no other test.
TEST_CASE("steady coils off the table's rows match an independent solution within 0.01 %", "[io][coil_theory]") {
    const double rows[][5] = {
        {0.05, 0.15, 0.02, 20.52, 0.0044528},  {0.1, 0.3, 0.02, 55.728, 0.0033855},   {0.5, 0.08, 0.02, 8.8174, 0.0090089},
        {0.05, 0.22, 0.05, 15.875, 0.0060263}, {0.25, 0.04, 0.05, 3.8853, 0.0077085}, {0.05, 0.3, 0.2, 5.4341, 0.011321},
        {0.5, 0.22, 0.2, 5.6058, 0.018332},    {0.1, 0.04, 1, 1.4406, 0.0076179},     {0.25, 0.15, 1, 1.4296, 0.029178},
        {0.5, 0.3, 1, 2.8037, 0.032057},       {0.1, 0.08, 5, 0.8552, 0.017604},      {0.25, 0.22, 5, 1.0085, 0.04036}};
    for (const auto& [speed, fall, viscosity, frequency, radius] : rows) {
        INFO(speed << " m/s from " << fall << " m, " << viscosity << " m^2/s");
        const CoilTheory theory = found(nozzle_of_5_mm(speed, fall, viscosity));
        CHECK(theory.frequency == Approx(frequency).epsilon(1e-4));
        CHECK(theory.radius == Approx(radius).epsilon(1e-4));
    }
}

// Without gravity and inertia a slender thread's coil has a universal shape: Omega H/U = 4, R = H/4. The error is of the order of the
// thread's thickness over the fall.
TEST_CASE("without gravity and inertia the coil of a thin thread tends to a quarter of its fall", "[io][coil_theory]") {
    double before = 0.15;
    for (const double slenderness : {0.04, 0.02, 0.01, 0.005}) {
        const CoilTheory theory = found({slenderness * 0.1, 0.1, 1e4, 0, 0.1, 0});
        const double off = std::abs(2 * std::numbers::pi * theory.frequency - 4);
        CHECK(off < 0.7 * before);
        CHECK(theory.radius / 0.1 == Approx(0.25).margin(0.3 * slenderness));
        CHECK(2 * std::numbers::pi * theory.frequency * theory.radius ==
              Approx(0.1 * std::pow(slenderness * 0.1 / theory.thread_radius, 2)).epsilon(1e-5));  // laid at rest
        before = off;
    }
    CHECK(before < 0.02);
}

// Omega_G = (g Q^3/(nu a^8))^(1/4) and Omega_I = (Q^4/(nu a^10))^(1/3) with the radius a at the coil (Ribe 2004), times numbers that hardly
// vary.
TEST_CASE("gravitational and inertial coils follow their scaling laws while the frequency triples", "[io][coil_theory]") {
    const double pi = std::numbers::pi;
    for (const double fall : {0.1, 0.14, 0.2, 0.28}) {
        const CoilTheory g = found({2.5e-3, 0.002, 5, 9.81, fall, 0});
        const double Q = pi * 2.5e-3 * 2.5e-3 * 0.002;
        CHECK(2 * pi * g.frequency / std::pow(9.81 * Q * Q * Q / 5 / std::pow(g.thread_radius, 8), 0.25) == Approx(0.5).margin(0.03));
    }
    for (const double fall : {0.2, 0.25, 0.3, 0.4}) {
        const CoilTheory i = found(nozzle_of_5_mm(0.05, fall, 0.02));
        const double Q = pi * 5e-3 * 5e-3 * 0.05;
        CHECK(2 * pi * i.frequency / std::cbrt(std::pow(Q, 4) / (0.02 * std::pow(i.thread_radius, 10))) == Approx(0.205).margin(0.003));
    }
}

TEST_CASE("surface tension makes a thread slower, and thicker where it lands", "[io][coil_theory]") {
    CoilParameters parameters = nozzle_of_5_mm(0.1, 0.12, 0.2);
    const CoilTheory without = found(parameters);
    parameters.surface_tension = 3e-5;
    const CoilTheory with = found(parameters);
    CHECK(with.thread_radius > without.thread_radius);
    CHECK(with.frequency != Approx(without.frequency).epsilon(1e-4));
}

TEST_CASE("a coil followed while fall, speed and viscosity change equals a new solution, with few solves", "[io][coil_theory]") {
    CoilSolver solver;
    CoilParameters p = nozzle_of_5_mm(0.25, 0.12, 1);
    REQUIRE(solver.at(p));
    for (int k = 0; k < 20; ++k) {
        p.fall *= 0.985, p.viscosity *= 0.96, p.speed *= 1.01;
        const auto theory = solver.at(p);
        REQUIRE(theory);
        CHECK(solver.effort() <= 12);
        if (k % 5 == 4) CHECK(theory->frequency == Approx(found(p).frequency).epsilon(1e-5));
    }
    // A jump of the input starts a new search.
    p.viscosity *= 0.2;
    const auto leapt = solver.at(p);
    REQUIRE(leapt);
    CHECK(leapt->frequency == Approx(found(p).frequency).epsilon(1e-6));
}

TEST_CASE("a coil continues bit-identically from its saved state", "[io][coil_theory]") {
    CoilSolver first, second;
    CoilParameters p = nozzle_of_5_mm(0.1, 0.12, 0.2);
    REQUIRE(first.at(p));
    std::stringstream state;
    first.save(state);
    second.load(state);
    p.fall *= 0.99;
    CHECK(first.at(p)->frequency == second.at(p)->frequency);
    CHECK(first.effort() == second.effort());
    CoilSolver cut;
    std::stringstream part(state.str().substr(0, 500));
    cut.load(part);
    CHECK(cut.at(p)->frequency == Approx(first.at(p)->frequency).epsilon(1e-6));
}

TEST_CASE("invalid and extreme input gives no coil or a finite one, with bounded effort", "[io][coil_theory]") {
    CoilSolver solver;
    CHECK_FALSE(solver.at({}));
    CHECK_FALSE(solver.at({5e-3, -1, 1, 9.81, 0.1, 0}));
    CHECK_FALSE(solver.at({5e-3, NAN, 1, 9.81, 0.1, 0}));
    CHECK_FALSE(solver.at({5e-3, 0.1, 1, 9.81, 4e-3, 0}));
    CHECK_FALSE(solver.at({5e-3, 1, 1e-6, 9.81, 0.5, 0}));  // water from half a metre
    for (const CoilParameters& p : {CoilParameters{5e-3, 0.1, 1e9, 9.81, 0.1, 0},
                                    {1e-6, 0.1, 1, 9.81, 10, 0},
                                    {0.09, 0.1, 1, 9.81, 0.1, 0},
                                    {5e-3, 0.1, 1, 9.81, 0.1, 1e3}}) {
        const auto theory = solver.at(p);
        CHECK(solver.effort() <= CoilSolver::most_effort + 40);
        if (theory) CHECK((std::isfinite(theory->frequency) && theory->frequency > 0 && theory->radius > 0));
    }
    const std::atomic<bool> give_up{true};
    CHECK_FALSE(solver.at(nozzle_of_5_mm(0.25, 0.08, 1), &give_up));
    CHECK(solver.effort() == 0);
}

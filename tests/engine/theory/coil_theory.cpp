#include "engine/theory/coil_theory.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <thread>

#include "engine/probes/coil_expectation.h"
#include "engine/scene/read.h"

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

const char* const pouring_scene = R"(
[time]
end = 1
[domain]
min = [-0.1, -0.1, -0.1]
max = [0.1, 0.2, 0.1]
[fluid]
spacing = 2e-3
viscosity = 1000
[models]
pressure = "coupled"
[[emitter]]
position = [0, 0.08, 0]
radius = 5e-3
speed = 0.25
)";

/// What theory takes from the scene at 1 s, after turns of half a second and a fall of 8 cm; with `from` replaced by `to` first.
std::optional<CoilParameters> parameters_of(const std::string& from = "", const std::string& to = "", const std::string& more = "") {
    std::string text = pouring_scene;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    const Scene scene = read_scene_text(text + more, "pouring.toml");
    const auto poured = pouring(scene, make_plan(scene), Vec3d::Zero(), Vec3d::UnitY());
    return poured ? steady_parameters(*poured, Vec3d::UnitY(), 1, 0.5, 0.08) : std::nullopt;
}

}  // namespace

TEST_CASE("steady coils of every regime have the published table's frequency and radius, within 0.01 %", "[io][coil_theory]") {
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

// Speed, fall, viscosity, frequency, radius: from another implementation (scipy's solve_bvp), settings that no other test has.
TEST_CASE("steady coils between and beyond the table's rows are those of an independent solution, within 0.01 %", "[io][coil_theory]") {
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

// Without gravity and inertia a slender thread's coil is a figure of its own: Omega H/U = 4, R = H/4; the thread's thickness counts by its
// share in the fall.
TEST_CASE("without gravity and inertia a thin thread coils on a quarter of its fall, the more so the thinner it is", "[io][coil_theory]") {
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
TEST_CASE("coils that gravity bends and coils that inertia bends follow their own scaling laws, while the frequency triples",
          "[io][coil_theory]") {
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

TEST_CASE("surface tension slows a thread that it draws together: it hangs thicker where it lands", "[io][coil_theory]") {
    CoilParameters parameters = nozzle_of_5_mm(0.1, 0.12, 0.2);
    const CoilTheory without = found(parameters);
    parameters.surface_tension = 3e-5;
    const CoilTheory with = found(parameters);
    CHECK(with.thread_radius > without.thread_radius);
    CHECK(with.frequency != Approx(without.frequency).epsilon(1e-4));
}

TEST_CASE("a coil followed as its fall, speed and viscosity change is the one found anew, and takes few solves", "[io][coil_theory]") {
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
    // A leap is a new search.
    p.viscosity *= 0.2;
    const auto leapt = solver.at(p);
    REQUIRE(leapt);
    CHECK(leapt->frequency == Approx(found(p).frequency).epsilon(1e-6));
}

TEST_CASE("a coil goes on from its saved state with the same bits", "[io][coil_theory]") {
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

TEST_CASE("nonsense and extremes have no coil or a finite one, within the bounded effort, and who gives up is answered at once",
          "[io][coil_theory]") {
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

TEST_CASE("what theory is asked follows the scene, and nothing is asked where it is not of such a thread", "[io][coil_theory]") {
    const auto plain = parameters_of();
    REQUIRE(plain);
    CHECK(plain->nozzle_radius == 5e-3);
    CHECK(plain->speed == 0.25);
    CHECK(plain->viscosity == Approx(1));
    CHECK(plain->gravity == 9.81);
    CHECK(plain->fall == 0.08);
    CHECK(parameters_of("speed = 0.25", "speed = 0.25\nviscosity = 300")->viscosity == Approx(0.3));
    CHECK(parameters_of("speed = 0.25", "speed = \"0.1 + 0.1*min(1, 4*t)\"")->speed == Approx(0.2));  // steady for the newest turn
    CHECK(parameters_of("viscosity = 1000", "viscosity = 1000\nsurface_tension = 0.05")->surface_tension == Approx(5e-5));
    CHECK(parameters_of("", "", "[[emitter]]\nposition = [0.05, 0.15, 0]\nradius = 0.004\nspeed = 0.1\n")->nozzle_radius ==
          5e-3);  // the one on the axis

    CHECK_FALSE(parameters_of("speed = 0.25", "speed = \"0.25*(1+0.8*sin(12*t))\""));
    CHECK_FALSE(parameters_of("speed = 0.25", "speed = 0"));
    CHECK_FALSE(parameters_of("speed = 0.25", "speed = 0.25\nstop = 0.9"));
    CHECK_FALSE(parameters_of("speed = 0.25", "speed = 0.25\ndirection = [1, -1, 0]"));
    CHECK_FALSE(parameters_of("viscosity = 1000", "viscosity = \"1000 + 100*age\""));
    CHECK_FALSE(parameters_of("viscosity = 1000", "viscosity = \"1000 + 100*x\""));
    CHECK_FALSE(parameters_of("radius = 5e-3", "shape = \"box\"\nwidth = 0.01\nthickness = 0.01"));
    CHECK_FALSE(parameters_of("max = [0.1, 0.2, 0.1]", "max = [0.1, 0.2, 0.1]\ngravity = [3, -9, 0]"));
    CHECK_FALSE(parameters_of("pressure = \"coupled\"", "pressure = \"wcsph\"\nviscosity = \"xsph\""));
    CHECK_FALSE(parameters_of("[[emitter]]\nposition = [0, 0.08, 0]\nradius = 5e-3\nspeed = 0.25\n",
                              "[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.02, 0.02, 0.02]\n"));
}

TEST_CASE("who does not wait for the theory has its answer soon, the same as who waits", "[io][coil_theory]") {
    CoilExpectation waits(TheorySearch::wait), goes_on(TheorySearch::in_background);
    CoilParameters p = nozzle_of_5_mm(0.1, 0.12, 0.2);
    const auto answer = waits.at(p);
    REQUIRE(answer);
    CHECK_FALSE(goes_on.at(p));
    std::optional<CoilTheory> soon;
    for (int k = 0; k < 600 && !soon; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(20)), soon = goes_on.at(p);
    REQUIRE(soon);
    CHECK(soon->frequency == answer->frequency);
    p.fall *= 1.001;
    CHECK(waits.at(p)->frequency == answer->frequency);  // near enough
    p.fall *= 1.05;
    CHECK(goes_on.at(p)->frequency == answer->frequency);  // until the new one is there
    CHECK(waits.at(p)->frequency != answer->frequency);

    std::stringstream state;
    waits.save(state);
    CoilExpectation resumed(TheorySearch::wait);
    resumed.load(state);
    p.fall *= 0.99;
    CHECK(resumed.at(p)->frequency == waits.at(p)->frequency);
}

/// The ledger of momentum: solids report the momentum that the fluid lost, and the force is correct.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/io/diagnostics.h"
#include "engine/particles/step_context.h"
#include "engine/probes/probes.h"
#include "engine/scene/read.h"
#include "engine/simulation/simulation.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace ledger_test {

namespace {

constexpr double g = 9.81;

/// Lines of a scene that choose the models.
struct Models {
    std::string name, keys;
    bool bodies = true;    ///< moves free ones
    double viscosity = 2;  ///< Pa s
};

const std::vector<Models>& splashing() {
    static const std::vector<Models> all{
        {"wcsph", text::models("wcsph")},
        {"wcsph, explicit", text::models("wcsph", "explicit")},
        {"constraint", text::models("ppe", "none")},
        {"constraint, explicit", text::models("ppe", "explicit")},
        {"constraint, full", text::models("ppe", "full")},
        {"constraint, spin", text::models("ppe") + "micropolar = \"notes\"\n", false},
        {"uncorrected", text::models("ppe", "full") + "[viscosity]\ncorrection = false\n", false},
        {"assembled", text::models("ppe", "full_assembled"), false},
        {"published", text::pressure_form("projection") + "source = \"density\"\n", false},
        {"coupled", text::models("coupled"), false, 20},
    };
    return all;
}

Vec3d momentum(const World& world) { return measure(world, Vec3d::Zero(), 1).momentum; }

/// Sums over a frame. The scene has the probe for which all solids keep a ledger.
struct Frame {
    Vec3d missing = Vec3d::Zero();  ///< change of the fluid's momentum, minus its weight's impulse, plus the impulse on solids [N s]
    double exchanged = 0;           ///< sum of the magnitudes of these impulses [N s]
    std::vector<Wrench> on;         ///< by solid, over the frame [N s]
};

Frame step_frame(Simulation& simulation, double end) {
    const World& world = simulation.world();
    Frame frame;
    frame.on.resize(world.solids.all.size());
    const Vec3d before = momentum(world);
    while (simulation.time() < end) {
        if (const auto& wrong = simulation.step(end).diverged) throw std::runtime_error(wrong->what);
        frame.missing -= static_cast<double>(world.step.dt) * static_cast<double>(world.step.mass) * world.fluid.size() *
                         world.step.gravity.cast<double>();
        for (std::size_t k = 0; k < frame.on.size(); ++k) {
            const Wrench received = world.solids.all[k].ledger.total();
            frame.on[k] += received, frame.missing += received.force, frame.exchanged += received.force.norm();
        }
    }
    frame.missing += momentum(world) - before;
    return frame;
}

/// Mean forces and torques on the solids from `from` to `to` [s].
std::vector<Wrench> mean_forces(Simulation& simulation, double from, double to) {
    run_until(simulation, from);
    std::vector<Wrench> mean = step_frame(simulation, to).on;
    for (Wrench& one : mean) one = 1 / (to - from) * one;
    return mean;
}

const std::string probe = "[[probe]]\nname = \"first\"\nkind = \"solid\"\nsolid = 0\n";

/// A column of fluid falls against a paddle that comes, under a ball that drops in.
Simulation impact(const Models& models, bool plane) {
    const auto at = [&](double x, double y, double z) { return text::point(plane ? 2 : 3, x, y, z); };
    const std::string motion = plane ? "position = [\"-t\", 0]" : "position = [\"-t\", 0, 0]",
                      body = plane ? "density = 700\nvelocity = [0, -1]" : "density = 700\nvelocity = [0, -1, 0]";
    return simulation_of(text::time(1) + text::domain(at(-0.3, -0.1, -0.2), at(0.5, 0.6, 0.4)) +
                         text::fluid(plane ? 0.0125 : 0.025, models.viscosity) + models.keys + text::block(at(0, 0, 0), at(0.2, 0.2, 0.2)) +
                         text::tank(at(0, 0, 0), at(0.4, 0.5, 0.2)) + text::box(at(0.26, -0.04, 0.04), at(0.32, 0.3, 0.16), motion) +
                         text::ball(at(0.1, 0.25, 0.1), 0.05, models.bodies ? body : "") + probe);
}

}  // namespace

TEST_CASE("forces on all solids and weight are the change of the fluid's momentum in an impact, within 1e-6", "[validation][ledger]") {
    // Velocities in float: 6e-8 of 1 m/s a particle and step, of both signs. An impulse that a stage did not report would be of the order
    // of 1e-2 or more.
    const bool plane = GENERATE(true, false);
    for (std::size_t number = plane ? 0 : 1; number < splashing().size(); number += plane ? 1 : 2) {  // every second one in 3D
        const Models& models = splashing()[number];
        INFO(models.name << (plane ? " in 2D" : " in 3D"));
        Simulation simulation = impact(models, plane);
        double pushed = 0;
        for (int k = 1; k <= 3; ++k) {
            const Frame frame = step_frame(simulation, 0.04 * k);
            CHECK(frame.missing.norm() < 1e-6 * frame.exchanged);
            pushed += frame.on[1].force.norm();
        }
        CHECK(pushed > 0.1 * momentum(simulation.world()).norm());
    }
}

TEST_CASE("a vessel that turns coupled honey receives what the fluid loses of momentum and spin, within 1e-5", "[validation][ledger]") {
    // The load that corrects the forces of the hydrostatic pressure, shifts and contact change the fluid's momentum, too.
    const std::string round = "shape = \"cylinder\"\nfrom = [0, 0, 0]\nradius = 0.048\n";
    Simulation simulation = simulation_of(text::time(1) + text::domain({-0.06, -0.01, -0.06}, {0.06, 0.12, 0.06}) + text::fluid(8e-3, 4) +
                                          text::models("coupled") + "[[block]]\n" + round + "to = [0, 0.036, 0]\n[[solid]]\n" + round +
                                          "to = [0, 0.11, 0]\ncontainer = true\nrotation = [0, 14, 0]\n" + probe);
    const auto spin = [&] { return measure(simulation.world(), Vec3d(0, -g, 0), 1).angular_momentum.y(); };
    for (int k = 1; k <= 4; ++k) {
        const double before = spin();
        const Frame frame = step_frame(simulation, 0.05 * k);
        CHECK(frame.missing.norm() < 1e-5 * frame.exchanged);
        CHECK(std::abs(spin() - before + frame.on[0].torque.y()) < 1e-5 * 0.048 * frame.exchanged);
    }
}

TEST_CASE("a free body's momentum changes by its weight and its ledger's impulses, to 1e-12", "[validation][ledger]") {
    for (const Models& models : splashing()) {
        if (!models.bodies) continue;
        INFO(models.name);
        Simulation simulation = impact(models, true);
        const World& world = simulation.world();
        const RigidBody& body = *world.solids.all[2].body;
        const Vec3d before = body.velocity;
        Vec3d received = Vec3d::Zero();
        while (simulation.time() < 0.08) {
            simulation.step(0.08);
            received += world.solids.all[2].ledger.total().force +
                        static_cast<double>(world.step.dt) * body.mass * world.step.gravity.cast<double>();
        }
        CHECK((body.mass * (body.velocity - before) - received).norm() < 1e-10 * received.norm() + 1e-10);
    }
}

TEST_CASE("a tank weighs its content within 1 %", "[validation][ledger]") {
    // .08 m square, .1 m deep. At rest the weight follows from the momentum, which the impact above checks for every model.
    const double weight = 1000 * g * 0.08 * 0.08 * 0.1;
    const std::vector<Models> still{
        {"constraint", ""},
        {"wcsph", text::models("wcsph")},
        {"projection", text::pressure_form("projection")},
        {"honey, coupled", text::models("coupled")},
    };
    for (const Models& models : still) {
        INFO(models.name);
        Simulation simulation =
            simulation_of(text::time(9) + text::domain({-0.02, -0.02, -0.02}, {0.1, 0.2, 0.1}) +
                          text::fluid(0.01, models.name.find("honey") == 0 ? 20 : 0) + models.keys +
                          text::block({0, 0, 0}, {0.08, 0.1, 0.08}) + text::tank({0, 0, 0}, {0.08, 0.18, 0.08}) + probe);
        const double from = models.name == "constraint" || models.name == "wcsph" ? 0.2 : 0.1;  // lattices that melt take longer
        const Vec3d force = mean_forces(simulation, from, 2 * from)[0].force;
        CHECK(force.y() == Approx(-weight).epsilon(0.01));
        CHECK(std::hypot(force.x(), force.z()) < 0.01 * weight);
    }
}

TEST_CASE("the lift of a submerged body is Archimedes' within 3 % for a disc of 6 d, 5 % for a ball of 3.5 d", "[validation][ledger]") {
    // 3.7 % too much were measured for the small ball: how its few particles settle moves it by some percent.
    struct Case {
        bool plane;
        std::string pressure;
        double R = 0.036;
    };
    for (const Case& one : {Case{true, "ppe"}, Case{true, "wcsph"}, Case{false, "ppe", 0.021}}) {
        const double R = one.R;
        INFO(one.pressure << (one.plane ? " in 2D" : " in 3D") << ", radius " << R);
        constexpr double d = 0.006;
        const double width = one.plane ? 0.12 : 0.084, depth = one.plane ? 0.102 : 0.078;
        const auto at = [&](double x, double y, double z) { return text::point(one.plane ? 2 : 3, x, y, z); };
        Simulation simulation =
            simulation_of(text::time(9) + text::domain(at(-0.02, -0.02, -0.02), at(0.14, 0.2, 0.14)) + text::fluid(d) +
                          text::models(one.pressure) + text::block(at(0, 0, 0), at(width, depth, width)) +
                          text::tank(at(0, 0, 0), at(width, 0.18, width)) + text::ball(at(width / 2, depth / 2, width / 2), R) + probe);
        const double lift = 1000 * g * std::numbers::pi * R * R * (one.plane ? 1 : 4 * R / 3);
        const std::vector<Wrench> on = mean_forces(simulation, 0.3, 0.6);
        CHECK(on[1].force.y() == Approx(lift).epsilon(R > 5 * d ? 0.03 : 0.05));
        CHECK(on[1].torque.norm() < 0.02 * lift * R);
    }
}

TEST_CASE("a jet on a plate has the pressure of free-streamline theory within 6 % of stagnation pressure", "[validation][ledger]") {
    // x = 2 b/pi (artanh q + arctan q), p = rho U^2/2 (1 - q^2) (Milne-Thomson 1968, Theoretical Hydrodynamics, 11.42). 10 spacings across
    // the jet, where the film that leaves along the plate has 5; gauges of two spacings, on both sides. Means over .6 s
    // on one side scatter by .03 from seed to seed.
    constexpr double b = 0.04, stagnation = 500;
    const std::vector<std::pair<double, double>> exact{{0, 1}, {0.02, 0.847}, {0.04, 0.461}, {0.06, 0.148}, {0.08, 0.035}};
    std::string scene = text::time(9) + text::domain({-0.15, -0.03}, {0.15, 0.2}, "gravity = [0, 0]") + text::fluid(0.004) +
                        text::box({-0.14, -0.03}, {0.14, 0}, "slip = \"free\"") +
                        "[[emitter]]\nposition = [0, 0.12]\ndirection = [0, -1]\nradius = 0.02\nspeed = 1\n";
    for (const auto& [x, part] : exact)
        for (const double side : {-1.0, 1.0})
            scene += fmt::format("[[probe]]\nname = \"at_{0}\"\nkind = \"gauge\"\nsolid = 0\nradius = 0.004\nat = [{0}, 0]\n",
                                 side * (x + 1e-9));
    Simulation simulation = simulation_of(scene);
    NamedProbes probes = make_probes(simulation, TheorySearch::wait);
    for (const double until : {0.2, 0.8}) {
        run_until(simulation, until, [&] {
            for (const auto& [name, probe] : probes) probe->after_step(simulation.world(), simulation.time());
        });
        for (std::size_t k = 0; k < exact.size(); ++k) {
            double pressure = 0;
            for (const std::size_t side : {2 * k, 2 * k + 1}) pressure += rows_of(*probes[side].second, simulation).at(0).at(1) / 2;
            INFO(exact[k].first << " m of a jet of " << b << " m");
            if (until > 0.3) CHECK(pressure / stagnation == Approx(exact[k].second).margin(0.06));
        }
    }
}

TEST_CASE("plates that shear a fluid have the stress mu U/h within 3 %, and opposite forces", "[validation][ledger]") {
    // 10 spacings apart, periodic along the plates, steady: h^2/nu is 0.01 s. Explicit forms have the wall's shear to 2 %.
    constexpr double U = 0.1, h = 0.05, mu = 250;
    for (const std::string& models : {text::models("ppe", "explicit"), text::models("ppe", "full"),
                                      text::models("ppe", "explicit") + "[pressure]\nform = \"projection\"\n",
                                      text::models("wcsph", "explicit") + "[pressure]\nsound_speed = 2\n"}) {
        INFO(models);
        Simulation simulation =
            simulation_of(text::time(9) + text::domain({0, -0.02}, {0.1, 0.07}, "periodic = [true, false, false]\ngravity = [0, 0]") +
                          text::fluid(0.005, mu) + models + text::block({0, 0}, {0.1, h}) + text::plane({0, 0}, {0, 1}) +
                          fmt::format("[[solid]]\nshape = \"plane\"\nnormal = [0, -1]\nposition = [\"{} * t\", {}]\n", U, h) + probe);
        const std::vector<Wrench> on = mean_forces(simulation, 0.03, 0.04);
        CHECK(on[1].force.x() == Approx(-mu * U / h * 0.1).epsilon(0.03));
        CHECK(on[0].force.x() == Approx(-on[1].force.x()).epsilon(0.005));
    }
}

TEST_CASE("a piston that presses thick fluid through a slit has lubrication's force at once, within 15 %", "[validation][ledger]") {
    // A chamber 24 spacings wide, a slit of 8 spacings and twice as long: 12 mu Q L/h^3, half of Hasimoto's loss at a slit in a thin plate,
    // 16 mu Q/(pi h^2), and 12 mu Q l/H^3 in the chamber. The flow is steady within 1 ms. The slit is an opening of 8 particles: the rest
    // of the fluid is enclosed. 10 %: a lattice of 8 spacings; later, disordered, both models press up to a third harder.
    constexpr double d = 1e-3, H = 24 * d, l = 30 * d, h = 8 * d, L = 16 * d, U = 0.01, Q = U * H;
    const auto [pressure, mu] = GENERATE(table<std::string, double>({{"ppe", 1}, {"ppe", 10}, {"coupled", 10}, {"coupled", 100}}));
    INFO(pressure << ' ' << mu);
    Simulation simulation = simulation_of(
        text::time(1) + text::domain({-0.05, -0.02}, {0.06, 0.02}, "gravity = [0, 0]") + text::fluid(d, mu) + text::models(pressure) +
        text::block({-l, -H / 2}, {0, H / 2}) + text::block({0, -h / 2}, {L, h / 2}) +
        text::box({-0.05, -H / 2}, {-l, H / 2}, fmt::format("position = [\"{}*t\", 0]", U)) + text::box({-0.05, H / 2}, {L, 0.02}) +
        text::box({-0.05, -0.02}, {L, -H / 2}) + text::box({0, h / 2}, {L, H / 2}) + text::box({0, -H / 2}, {L, -h / 2}) + probe);
    const double exact = mu * Q * H * (12 * L / (h * h * h) + 16 / (std::numbers::pi * h * h) + 12 * l / (H * H * H));
    CHECK(mean_forces(simulation, 0.02, 0.06)[0].force.x() == Approx(-exact).epsilon(0.15));
    CHECK(largest_speed(velocities(simulation)) < 8 * U);
}

TEST_CASE("coaxial cylinders have the torque of Couette flow within 5 %", "[validation][ledger]") {
    // 12.5 spacings apart, radii of 12.5 and 25, steady within 1 %: (b - a)^2/nu is 0.125 s. 4 pi mu Omega/(1/a^2 - 1/b^2) is exact.
    constexpr double a = 0.025, b = 0.05, mu = 5, Omega = 4;
    // Weakly compressible particles lose their order until .3 s: 12 % too much at .2 s without shifting, 1 % too little with it.
    for (const std::string& models : {text::models("coupled"), text::models("ppe", "full"), text::models("wcsph", "full")}) {
        INFO(models);
        Simulation simulation =
            simulation_of(text::time(9) + text::domain({-0.06, -0.06}, {0.06, 0.06}, "gravity = [0, 0]") + text::fluid(0.002, mu) + models +
                          text::drop({0, 0}, b) + text::ball({0, 0}, b, "container = true") +
                          text::ball({0, 0}, a, fmt::format("rotation = [0, 0, {}]", Omega)) + probe);
        const bool sound = models.find("wcsph") != std::string::npos;
        const std::vector<Wrench> on = mean_forces(simulation, sound ? 0.2 : 0.06, sound ? 0.24 : 0.1);
        const double torque = 4 * std::numbers::pi * mu * Omega / (1 / (a * a) - 1 / (b * b));
        CHECK(on[1].torque.z() == Approx(-torque).epsilon(0.05));
        CHECK(on[0].torque.z() == Approx(-on[1].torque.z()).epsilon(0.05));
    }
}

TEST_CASE("a ball in a lattice of balls has Hasimoto's drag within 7 %, with 5 spacings in its radius", "[validation][ledger]") {
    // Pushed by its weight, steady within 1 %. Drag over 6 pi mu a U, U the mean velocity of ball and fluid: 1/(1 - 1.7601 c^(1/3) + c -
    // 1.5593 c^2), c the ball's share of the volume. The pressure that pushes acts on the ball, too: 1/(1 - c) times the force. It is 5 to
    // 6 % too small, as if the ball were .15 spacings smaller.
    constexpr double a = 0.025, L = 0.1, mu = 100, G = 0.5;
    const std::string periodic = fmt::format("periodic = [true, true, true]\ngravity = [{}, 0, 0]", G);
    Simulation simulation =
        simulation_of(text::time(9) + text::domain({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}, periodic) + text::fluid(0.005, mu) +
                      text::block({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}) + text::ball({0, 0, 0}, a));
    run_until(simulation, 0.05);
    const double volume = std::pow(0.005, 3), U = momentum(simulation.world()).x() / (1000 * L * L * L),
                 c = 4 * std::numbers::pi / 3 * std::pow(a / L, 3);
    const double drag = 1000 * G * volume * simulation.world().fluid.size() / (1 - c), k = std::cbrt(c);
    CHECK(drag / (6 * std::numbers::pi * mu * a * U) == Approx(1 / (1 - 1.7601 * k + c - 1.5593 * c * c)).epsilon(0.07));
}

}  // namespace ledger_test

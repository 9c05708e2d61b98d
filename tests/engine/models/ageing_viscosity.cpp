/// Viscosity by emitter and by age, through whole runs from the text of a scene.
#include "engine/models/viscosity/ageing_viscosity.h"

#include <catch2/catch.hpp>
#include <limits>
#include <sstream>

#include "engine/scene/read.h"
#include "engine/simulation/simulation.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace {

/// Two nozzles side by side over a block, without contact.
const std::string pour = text::time(0.1) + text::domain({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, "gravity = [0, 0, 0]") +
                         text::fluid(5e-3, 0, "viscosity = \"30 + 1000*x\"") + text::models("ppe", "full") +
                         text::block({-0.02, -0.09, -0.02}, {0.02, -0.07, 0.02}) +
                         "[[emitter]]\nposition = [-0.05, 0, 0]\nradius = 0.01\nspeed = 0.2\nviscosity = 3\n"
                         "[[emitter]]\nposition = [0.05, 0, 0]\nradius = 0.01\nspeed = 0.2\nviscosity = \"2 + 100*age\"\n";

}  // namespace

TEST_CASE("each emitter sets its viscosity, also by age, and initial fluid keeps that of its position", "[sim][viscosity]") {
    Simulation simulation = simulation_of(pour);
    while (simulation.time() < 0.1) REQUIRE_FALSE(simulation.step(0.1).diverged);
    const World& w = simulation.world();
    const auto mu = w.fluid.column<field::viscosity>();
    const auto x = w.fluid.column<field::position>();
    const auto role = w.fluid.column<field::role>();
    int left = 0, right = 0, below = 0;
    for (std::size_t i = 0; i < mu.size(); ++i) {
        if (x[i].y() < -0.06) {
            ++below;
            CHECK(mu[i] == Approx(30 + 1000 * x[i].x()).margin(0.1));
        } else if (x[i].x() < 0) {
            ++left;
            CHECK(mu[i] == 3);
        } else if (role[i] < 0) {
            CHECK(mu[i] == 2);  // fluid inside the nozzle does not age
        } else {
            ++right;  // 0.2 m/s from the nozzle at y = 0: age = -y/0.2 to within two steps of 5 ms at most
            CHECK(mu[i] == Approx(2 + 100 * -x[i].y() / 0.2).margin(100 * 0.01));
        }
    }
    CHECK(below > 100);
    CHECK(left > 40);  // 0.02 m of jet is 50 particles
    CHECK(right > 40);
}

TEST_CASE("a run with ageing viscosity resumes bit-identically", "[sim][viscosity][resume]") { CHECK(differing_bits(pour, 0.1) == ""); }

TEST_CASE("a live change of fluid.viscosity leaves fluid of emitters with their viscosity unchanged", "[sim][viscosity][change]") {
    const auto changed = [](const std::string& viscosity) {
        ReadRequest request;
        request.changes.push_back({"fluid.viscosity", parse_value(viscosity, "test")});
        return read_scene_text(pour, "test.toml", request);
    };
    Simulation simulation = simulation_of(pour);
    while (simulation.time() < 0.1) REQUIRE_FALSE(simulation.step(0.1).diverged);
    const auto mu = [&] { return simulation.world().fluid.column<field::viscosity>(); };
    const std::vector<Real> before(mu().begin(), mu().end());

    // Changes to an expression of the particles' current position and of their age, which is 0.1 s for the initial fluid.
    const Scene after = changed("\"60 + 500*y + 1000*age\"");
    simulation.change(after, make_plan(after));
    const auto x = simulation.world().fluid.column<field::position>();
    int touched = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        const bool block = x[i].y() < -0.06;
        touched += block;
        CHECK(mu()[i] == Approx(block ? 60 + 500 * x[i].y() + 100 : before[i]).epsilon(1e-5));
    }
    CHECK(touched > 100);

    // Ageing fluid continues to age by the new expression, from its position at the change.
    while (simulation.time() < 0.15) REQUIRE_FALSE(simulation.step(0.15).diverged);
    const auto source = simulation.world().fluid.column<field::source>();
    const auto start = simulation.world().fluid.column<field::birthplace>();
    const double last = 0.15 - simulation.totals().last_step;  // the age in the last step
    for (std::size_t i = 0; i < source.size(); ++i) {
        if (source[i] == 0) CHECK(mu()[i] == Approx(60 + 500 * start[i].y() + 1000 * last).epsilon(1e-4));
        if (source[i] == 1) CHECK(mu()[i] == 3);
    }
}

TEST_CASE("without ageing a live change of fluid.viscosity leaves an emitter with its viscosity unchanged", "[sim][viscosity][change]") {
    std::string text = pour;
    text.replace(text.find("\"2 + 100*age\""), 13, "7");
    Simulation simulation = simulation_of(text);
    CHECK_FALSE(simulation.world().fluid.has<field::age>());
    while (simulation.time() < 0.05) REQUIRE_FALSE(simulation.step(0.05).diverged);
    ReadRequest request;
    request.changes.push_back({"fluid.viscosity", Value(50.0)});
    const Scene after = read_scene_text(text, "test.toml", request);
    simulation.change(after, make_plan(after));
    const auto x = simulation.world().fluid.column<field::position>();
    const auto mu = simulation.world().fluid.column<field::viscosity>();
    for (std::size_t i = 0; i < mu.size(); ++i) CHECK(mu[i] == (x[i].y() < -0.06 ? 50 : x[i].x() < 0 ? 3 : 7));

    // An invalid value is also reported after a checkpoint that was written before any step with it.
    request.changes.back().value = Value(std::string("abs(x-0.0125) < 0.001 ? 0-1 : 30"));
    const Scene wrong = read_scene_text(text, "test.toml", request);
    simulation.change(wrong, make_plan(wrong));
    std::stringstream saved;
    simulation.save(saved);
    Simulation resumed = simulation_of(text);
    resumed.changed_before(wrong, make_plan(wrong), 0.05);
    resumed.load(saved);
    for (Simulation* s : {&simulation, &resumed}) {
        const auto& diverged = s->step(0.1).diverged;
        REQUIRE(diverged);
        CHECK(diverged->what == "fluid.viscosity is -1 Pa s");
    }
}

TEST_CASE("a viscosity that becomes negative with age is refused before the run", "[plan]") {
    std::string text = pour;
    text.replace(text.find("2 + 100*age"), 11, "2 - 100*age");
    const Scene scene = read_scene_text(text, "test.toml");
    CHECK_THROWS_WITH(make_plan(scene), Catch::Contains("emitter[1].viscosity is") && Catch::Contains("at the age of"));
}

TEST_CASE("an invalid viscosity is reported at the start with key and place, later as the end of the run", "[sim][viscosity]") {
    const auto with = [](const std::string& key, const std::string& value) {
        ReadRequest request;
        for (const auto& [k, v] : {std::pair{key, value}, {"time.fixed_step", "0.01"}, {"time.end", "1"}})
            request.changes.push_back({k, parse_value(v, "test")});
        if (key == "block[0].spin")  // such fluid has one viscosity
            for (const auto& [k, v] : {std::pair{"models.micropolar", "bender"},
                                       {"fluid.viscosity", "30"},
                                       {"emitter[0].viscosity", "30"},
                                       {"emitter[1].viscosity", "30"}})
                request.changes.push_back({k, parse_value(v, "test")});
        return read_scene_text(pour, "test.toml", request);
    };
    const auto run = [&](const Scene& scene) { return Simulation(scene, make_plan(scene)); };
    // Too thin to be hit by the sample points of the scene's checks. Particles are at x = 0.0125.
    const std::string hole = "abs(x-0.0125) < 0.001 ? ";
    for (const auto& [key, value, expected] : std::vector<std::array<std::string, 3>>{
             {"fluid.viscosity", "\"" + hole + "0-1 : 30\"", "fluid.viscosity is -1 Pa s at (0.0125"},
             {"fluid.viscosity", "\"" + hole + "sqrt(0-1) : 30\"", "nan Pa s at (0.0125"},
             {"fluid.viscosity", "\"" + hole + (sizeof(Real) == 4 ? "1e39" : "1e300*1e300") + " : 30\"", "; allowed: up to "},
             {"block[0].velocity", "[\"" + hole + "sqrt(0-1) : 0\", 0, 0]", "block[0].velocity is not finite at (0.0125"},
             {"block[0].spin", "[\"" + hole + "sqrt(0-1) : 0\", 0, 0]", "block[0].spin is not finite at (0.0125"},
             {"block[0].ink", "[\"" + hole + "sqrt(0-1) : 0\"]", "block[0].ink is not a number at (0.0125"}}) {
        INFO(key << " = " << value);
        CHECK_THROWS_WITH(run(with(key, value)), Catch::StartsWith("test") && Catch::Contains(expected));
    }

    const auto end_of = [](Simulation& simulation) {
        while (simulation.time() < 0.2)
            if (const auto& d = simulation.step(0.2).diverged) return d->stage + ": " + d->what;
        return std::string("none");
    };
    Simulation poured = run(with("emitter[0].viscosity", "\"y > 0.006 ? 0-1 : 3\""));
    CHECK(end_of(poured) == "new fluid: emitter[0].viscosity is -1 Pa s");
    Simulation dyed = run(with("emitter[0].ink", "[\"sqrt(0.05-t)\"]"));
    CHECK(end_of(dyed) == "new fluid: emitter[0].ink is not a number");
    Simulation aged = run(with("fluid.viscosity", "\"abs(age-0.05) < 5e-4 ? 0-1 : 30\""));
    CHECK(end_of(aged) == "ageing: it is -1 Pa s at the age of 0.05 s");
    Simulation changed = run(with("fluid.viscosity", "\"30 + x\""));
    changed.step(0.01);
    const Scene after = with("fluid.viscosity", "\"" + hole + "0-1 : 30\"");
    changed.change(after, make_plan(after));
    CHECK(end_of(changed) == "new fluid: fluid.viscosity is -1 Pa s");
}

TEST_CASE("beyond the last age with a valid viscosity a particle keeps the last valid value", "[viscosity]") {
    const auto at = [](const std::string& viscosity, double age, double time, double dt) {
        ReadRequest request;
        request.changes.push_back({"fluid.viscosity", Value(viscosity)});
        StepContext step;
        step.time = time, step.dt = static_cast<Real>(dt);
        StepReport report;
        const std::vector<std::int16_t> zero{0};
        const std::vector<Vec3> x{Vec3::Zero()};
        std::vector<Real> ages{static_cast<Real>(age)}, mu{-1};
        AgeingViscosity{{read_scene_text(pour, "test.toml", request).fluid.viscosity}}(step, report, {zero}, {x}, {zero}, {{ages}}, {{mu}});
        return report.diverged ? -1 : static_cast<double>(mu[0]);
    };
    CHECK(at("1-age", 1.00007, 0.9999, 1e-4) == Approx(1e-4).epsilon(0.01));
    CHECK(at("sqrt(1-age)", 1.00007, 0.9999, 1e-4) == Approx(0.01).epsilon(0.01));
    const double out_late = at("0.5-age", 0.500002 + 50000 * 0.25 * std::numeric_limits<Real>::epsilon(), 8.5, 1e-5);
    CHECK((out_late >= 0 && out_late < 0.01));
    CHECK(at("0.9-age", 1.00007, 0.9999, 1e-4) == -1);
    CHECK(at("sqrt(0.9-age)", 1.00007, 0.9999, 1e-4) == -1);
    CHECK(at("1/(0.5-age)", 0.5, 0.5, 1e-4) > 0);
}

/// Temperatures in whole scenes.
#include "engine/models/temperature/temperature.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/io/diagnostics.h"
#include "engine/io/snapshot.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/scene/read.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace temperature_scene_test {

namespace {

/// A column of fluid that collapses in a tank. @param fluid, more keys of [fluid] and further lines
std::string dam(const std::string& pressure, const std::string& fluid, const std::string& block, const std::string& more = "") {
    return text::time(0.2, "fps = 10") + text::domain({0, 0}, {0.2, 0.2}) + text::fluid(0.01, 0, fluid) + text::models(pressure) +
           text::block({0, 0}, {0.1, 0.1}, block) + text::tank({0, 0}, {0.2, 0.2}, more);
}

bool has_stage(const Simulation& simulation, const std::string& name) {
    const auto& stages = simulation.assembly().stages;
    return std::any_of(stages.begin(), stages.end(), [&](const Stage& stage) { return stage.name == name; });
}

std::string refusal(const std::string& scene) {
    try {
        simulation_of(scene);
    } catch (const InputError& error) { return error.problems()[0].what; }
    return "";
}

}  // namespace

TEST_CASE("a scene without a temperature has no column and no stage for it", "[sim][temperature]") {
    const Simulation cold = simulation_of(dam("ppe", "viscosity = 1\n", ""));
    CHECK(cold.world().fluid.find("temperature") == nullptr);
    CHECK(cold.world().fluid.find("temperature_rest") == nullptr);
    CHECK_FALSE(has_stage(cold, "heat"));
    CHECK_FALSE(measure_heat(cold.world(), cold.scene().heat.law()).has_value());
    const Simulation warm = simulation_of(dam("ppe", "viscosity = 1\n", "", "temperature = 300"));
    CHECK(warm.world().fluid.find("temperature")->lasting);
    CHECK(has_stage(warm, "heat"));
}

TEST_CASE("a collapsing column keeps its heat to 1e-6 with every pressure model", "[sim][temperature]") {
    for (const char* pressure : {"wcsph", "ppe", "coupled"}) {
        Simulation run = simulation_of(dam(pressure, "viscosity = 2\n", "temperature = \"x < 0.05 ? 300 : 350\"\n"));
        const HeatLaw law = run.scene().heat.law();
        const HeatMeasures before = *measure_heat(run.world(), law);
        run_until(run, 0.2);
        const HeatMeasures after = *measure_heat(run.world(), law);
        CAPTURE(pressure);
        CHECK(run.totals().lost_particles == 0);
        CHECK(after.total == Approx(before.total).epsilon(1e-6));
        CHECK(after.coldest > 299.9);
        CHECK(after.hottest < 350.1);
    }
}

TEST_CASE("a melting run resumes bit-identically, on any number of threads", "[sim][temperature]") {
    CHECK(differing_bits(dam("coupled", "viscosity = \"2 + 100/(1 + exp((temperature - 310)))\"\n", "temperature = 300\n",
                             "temperature = \"x < 0.1 ? 350 : 290\"\nfilm = 500\n") +
                             "[heat]\nlatent_heat = 1e4\nmelting_range = [305, 315]\nair = 290\nfilm = 10\nemissivity = 0.9\n",
                         0.2) == "");
}

TEST_CASE("viscosity is the expression of each particle's temperature and place at the start", "[sim][temperature]") {
    Simulation run = simulation_of(dam("coupled", "viscosity = \"temperature + 100*x\"\n", "temperature = \"300 + 100*y\"\n"));
    run_until(run, 0.05);
    const ParticleStore& fluid = run.world().fluid;
    const auto T = fluid.column<field::temperature>(), mu = fluid.column<field::viscosity>();
    const auto start = fluid.column<field::birthplace>();
    for (std::size_t i = 0; i < T.size(); ++i)  // the temperature has changed since the step began
        CHECK(mu[i] == Approx(T[i] + 100 * start[i].x()).margin(0.01));
}

TEST_CASE("yield stress is the expression of each particle's temperature, and resumes bit-identically", "[sim][temperature][yield]") {
    const auto pressure = GENERATE(as<std::string>{}, "ppe", "coupled");
    const auto square = [&](const std::string& tau) {  // without weight; its viscosity alone stops the strain within 1 s
        return text::time(1, "max_step = 5e-3") + text::domain({-0.2, -0.2}, {0.2, 0.2}, "gravity = [0, 0]") +
               text::fluid(0.01, 0, "viscosity = 1\nyield_stress = " + tau + "\n") +
               text::models(pressure, pressure == "ppe" ? "full" : "") +
               text::block({-0.05, -0.05}, {0.05, 0.05}, "temperature = \"x < 0 ? 300 : 400\"\nvelocity = [\"10*y\", \"0\"]");
    };
    Simulation plain = simulation_of(square("30")), same = simulation_of(square("\"30 + 0*temperature\"")),
               frozen = simulation_of(square("\"temperature < 350 ? 3000 : 0\""));
    for (Simulation* s : {&plain, &same, &frozen}) run_until(*s, 0.03);
    const auto u = plain.world().fluid.column<field::velocity>(), same_u = same.world().fluid.column<field::velocity>();
    for (std::size_t i = 0; i < u.size(); ++i) REQUIRE(u[i] == same_u[i]);
    const auto gamma = frozen.world().fluid.column<field::shear_rate>();
    const auto x = frozen.world().fluid.column<field::position>();
    for (std::size_t i = 0; i < gamma.size(); ++i) {  // 10 1/s at the start; two spacings between them follow both
        if (x[i].x() < -0.02f) CHECK(gamma[i] < 1);
        if (x[i].x() > 0.02f) CHECK(gamma[i] > 3);
    }
    CHECK(differing_bits(square("\"temperature < 350 ? 3000 : 0\""), 0.02) == "");
}

TEST_CASE("an emitter sets its temperature, frames and diagnostics have it", "[sim][temperature]") {
    Simulation run = simulation_of(text::time(1, "fps = 10") + text::domain({-0.1, -0.3, -0.1}, {0.1, 0.3, 0.1}, "gravity = [0, 0, 0]") +
                                   text::fluid(0.01) + text::models("none", "none") +
                                   text::emitter({0, 0, 0}, 0.02, 0.2, "temperature = \"t < 0.5 ? 300 : 400\"\n"));
    run_until(run, 1);
    const Frame frame = Snapshots(run, {"temperature"}).take(run, 1);
    REQUIRE(frame.scalar.count("temperature") == 1);
    const std::vector<float>& T = frame.scalar.at("temperature");
    for (std::size_t i = 0; i < T.size(); ++i) {
        const float entered = 1 - (0.03f - frame.position[i].y()) / 0.2f;
        if (std::abs(entered - 0.5f) > 0.08f) CHECK(T[i] == Approx(entered < 0.5f ? 300 : 400).margin(0.1));
    }
    Measures measures;
    measures.heat = measure_heat(run.world(), run.scene().heat.law());
    const std::string plain = diagnostics_header(), warm = diagnostics_header(true);
    CHECK(warm == plain.substr(0, plain.size() - (plain.back() == '\n')) + ",heat,temperature_mean,temperature_min,temperature_max" +
                      (plain.back() == '\n' ? "\n" : ""));
    const auto cells = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
    CHECK(cells(diagnostics_row(1, 1, measures, {}, {}, 0, 0)) == cells(warm));
}

TEST_CASE("a solid that gets its first temperature during a run meets fluid of the air's temperature", "[sim][temperature]") {
    Simulation run = simulation_of(dam("ppe", "viscosity = 1\n", ""));
    run_until(run, 0.1);
    Scene now = run.scene();
    now.solids[0].heat.temperature = Expression(350.0);
    run.change(now, make_plan(now), run.time());
    for (const Real T : run.world().fluid.column<field::temperature>()) REQUIRE(T == static_cast<Real>(293.15));
    run_until(run, 0.2);
    const HeatMeasures heat = *measure_heat(run.world(), now.heat.law());
    CHECK(heat.coldest > 293.1);
    CHECK(heat.hottest > 293.16);
}

TEST_CASE("a temperature that is given in degrees C gets a warning", "[sim][temperature]") {
    const auto warned = [](const std::string& T) {
        const Scene scene = read_scene_text(dam("ppe", "viscosity = 1\n", "temperature = " + T + "\n"), "test.toml");
        const std::vector<std::string> all = make_plan(scene).warnings;
        return std::count(all.begin(), all.end(), "block[0].temperature = " + T + " is -238 degrees C; temperatures are in K");
    };
    CHECK(warned("35") == 1);
    CHECK(warned("308") == 0);
}

TEST_CASE("keys of heat without a temperature, and impossible ones, are refused", "[sim][temperature]") {
    CHECK(refusal(dam("ppe", "", "") + "[heat]\nfilm = 10\n") == "heat.film has no effect: the scene has no temperature");
    CHECK(refusal(dam("ppe", "viscosity = \"temperature\"\n", "")) == "fluid.viscosity depends on temperature, and the scene has none");
    CHECK(refusal(dam("coupled", "viscosity = 1\nyield_stress = \"temperature\"\n", "")) ==
          "fluid.yield_stress depends on temperature, and the scene has none");
    CHECK(refusal(dam("coupled", "viscosity = 10\nyield_stress = \"320 - temperature\"\n", "temperature = 330\n"))
              .find("fluid.yield_stress is -0.0") == 0);
    CHECK(refusal(dam("ppe", "", "temperature = 300\n") + "[heat]\nmelting_range = [310, 300]\n") ==
          "heat.melting_range goes from 310 to 300 K");
    CHECK(refusal(dam("ppe", "", "temperature = 300\n", "temperature = 300\nheat_flux = 1\n")) ==
          "solid[0] has both a temperature and a heat_flux");
    CHECK(refusal(dam("ppe", "", "temperature = 300\n", "film = 5\n")) == "solid[0].film is for solids with a temperature");
    CHECK(refusal(dam("ppe", "", "temperature = \"x - 0.05\"\n")).find("block[0].temperature is -0.0") == 0);
}

}  // namespace temperature_scene_test

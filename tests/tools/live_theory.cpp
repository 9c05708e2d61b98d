/// What theory says beside what a live run measures.
#include <catch2/catch.hpp>

#include "engine/theory/coil_theory.h"
#include "tests/support/live_program.h"

using namespace whorl;
using nlohmann::json;
using test::LiveProgram;

TEST_CASE("the state has theory's frequency and radius beside the coil's, for the viscosity, speed and gravity of the moment",
          "[tools][live]") {
    LiveProgram live(test::coiling_honey, {"--unpaced"});
    const auto seen = [&](double speed, double viscosity, double gravity) {
        return live.wait_for([&](const json& s) {
            const json& coil = s.at("probes").at("coil");
            if (!coil.at("theory_frequency").is_number() || !coil.at("fall").is_number()) return false;
            CoilSolver solver;
            const auto theory = solver.at({5e-3, speed, viscosity, gravity, coil.at("fall"), 0});
            return theory && std::abs(coil.at("theory_frequency").get<double>() / theory->frequency - 1) < 0.005 &&
                   std::abs(coil.at("theory_radius").get<double>() / theory->radius - 1) < 0.005;
        });
    };
    CHECK(live.state().at("probes").at("coil").at("theory_frequency").is_null());
    CHECK(seen(0.25, 1, 9.81));
    const json coil = live.state().at("probes").at("coil");
    CHECK(coil.at("frequency").get<double>() == Approx(coil.at("theory_frequency").get<double>()).epsilon(0.3));
    CHECK(live.post("/set", R"({"fluid.viscosity": 300})").status == 200);
    CHECK(seen(0.25, 0.3, 9.81));
    CHECK(live.post("/set", R"({"emitter[0].speed": 0.3, "domain.gravity": [0, -5, 0]})").status == 200);
    CHECK(seen(0.3, 0.3, 5));
    CHECK(live.post("/set", R"json({"emitter[0].speed": "0.2*(1+0.8*sin(12*t))"})json").status == 200);  // nothing steady
    CHECK(live.wait_for([](const json& s) { return s.at("probes").at("coil").at("theory_frequency").is_null(); }));
    CHECK(live.end().code == 0);
}

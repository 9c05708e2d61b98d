/// Keys whose values change during a run.
#include <catch2/catch.hpp>
#include <cstring>
#include <sstream>

#include "engine/scene/read.h"
#include "engine/simulation/simulation.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using namespace whorl::test;

namespace change_test {

namespace {

/// Syrup falls from a nozzle on a plate that moves and turns.
const std::string syrup = text::time(1, "max_step = 5e-3") + text::domain({-0.06, -0.02, -0.06}, {0.06, 0.08, 0.06}) +
                          text::fluid(5e-3, 20) + text::models("ppe", "full") +
                          "[[emitter]]\nposition = [0, 0.05, 0]\nradius = 8e-3\nspeed = \"0.4\"\n" +
                          text::box({-0.05, -0.01, -0.05}, {0.05, 0, 0.05}, "position = [\"0.1*t\", 0, 0]\nrotation = [0, 3, 0]");

Scene scene_of(const std::vector<std::pair<std::string, std::string>>& changes = {}) {
    ReadRequest request;
    for (const auto& [key, value] : changes) request.changes.push_back({key, parse_value(value, "test")});
    return read_scene_text(syrup, "test.toml", request);
}

}  // namespace

TEST_CASE("setting the current values changes no bit, also where the notes or a calibration set others", "[sim][change]") {
    const std::string eddy = text::time(1) + text::domain({-1, -1, -1}, {2, 2, 2}) + text::plane({0, -0.1, 0}, {0, 1, 0}) +
                             text::block({0, 0, 0}, {0.5, 0.5, 0.5}, "velocity = [\"sin(3*y)\", \"cos(2*x)\", \"0\"]") +
                             "[pressure]\nsound_speed = 20\n";
    const std::string printed = text::fluid(0.1, 0.5, "density = 1") + text::models("wcsph", "explicit") +
                                "micropolar = \"notes\"\nnotes = \"as_printed\"\n[micropolar]\ntransfer_viscosity = 0.3\n",
                      calibrated = text::fluid(0.1) + text::models("wcsph", "explicit") +
                                   "micropolar = \"bender\"\n[micropolar]\neffective_viscosity = 3\nspin_length = 0.1\n";
    for (const std::string& text : {syrup, eddy + printed, eddy + calibrated}) {
        INFO(text);
        const Scene scene = read_scene_text(text, "test.toml");
        Simulation changed(scene, make_plan(scene)), untouched(scene, make_plan(scene));
        for (const double until : {0.04, 0.08, 0.12}) {
            run_until(changed, until), run_until(untouched, until);
            changed.change(scene, make_plan(scene));
        }
        CHECK(state_of(changed) == state_of(untouched));
    }
}

TEST_CASE("changes of viscosity, emitter, gravity and solids act from the frame time on", "[sim][change]") {
    const Scene before = scene_of();
    const Scene after = scene_of({{"fluid.viscosity", "5"},
                                  {"emitter[0].speed", "0.2"},
                                  {"domain.gravity", "[0, -5, 0]"},
                                  {"solid[0].position", "[0, 0, \"0.2*t\"]"},
                                  {"solid[0].rotation", "[0, -1, 0]"}});
    Simulation simulation(before, make_plan(before));
    run_until(simulation, 0.1);
    const Pose earlier = simulation.world().solids.all[0].pose;
    const double pushed = simulation.emitters()[0].expected_particles();
    REQUIRE(changes_of_models(simulation.plan(), make_plan(after)).empty());
    simulation.change(after, make_plan(after));

    const Pose now = simulation.world().solids.all[0].pose;
    CHECK((now.translation - earlier.translation).norm() < 1e-7f);  // rounding of float
    CHECK((now.rotation - earlier.rotation).norm() < 1e-6f);
    for (const Real mu : simulation.world().fluid.column<field::viscosity>()) CHECK(mu == 5);

    run_until(simulation, 0.2);
    const Pose moved = simulation.world().solids.all[0].pose;
    const Vec3 by = moved.translation - earlier.translation;
    CHECK(by.x() == Approx(0).margin(1e-6));
    CHECK(by.z() == Approx(0.2 * 0.1).epsilon(1e-4));
    CHECK(moved.angular_velocity.y() == Approx(-1).epsilon(1e-3));
    CHECK(simulation.world().step.gravity.y() == Approx(-5));
    // The amount emitted before stays; then half as much per second, to the rounding of time steps in single precision.
    CHECK(simulation.emitters()[0].expected_particles() - pushed == Approx(pushed / 2).epsilon(1e-6));
}

namespace {

/// The state at `end` of a run that continues from the state saved after its change at `changed` [s].
std::string resumed_to(double end, const std::string& saved, const Scene& before, const Scene& after, double changed) {
    Simulation resumed(before, make_plan(before));
    std::istringstream in(saved);
    resumed.load(in);
    resumed.changed_before(after, make_plan(after), changed);
    run_until(resumed, end);
    return state_of(resumed);
}

}  // namespace

TEST_CASE("a run resumed after a change equals the uninterrupted run", "[sim][change]") {
    const Scene before = scene_of(), after = scene_of({{"fluid.viscosity", "\"5 + 100*y\""},
                                                       {"solid[0].rotation", "[0, \"2*sin(9*t)\", 0]"},
                                                       {"emitter[0].speed", "\"0.3+t\""}});
    Simulation whole(before, make_plan(before));
    run_until(whole, 0.1);
    whole.change(after, make_plan(after));
    run_until(whole, 0.15);
    const std::string saved = state_of(whole);
    run_until(whole, 0.2);

    CHECK(resumed_to(0.2, saved, before, after, 0.1) == state_of(whole));
}

TEST_CASE("a change between frame times restarts lagged values, and a resumed run is bit-identical", "[sim][change]") {
    const Scene before = scene_of(), after = scene_of({{"fluid.viscosity", "40"}, {"solid[0].position", "[0, 0, \"0.2*t\"]"}});
    const auto half_way = [&](Simulation& simulation) {
        run_until(simulation, 0.1);
        simulation.step(0.15);
        simulation.change(after, make_plan(after), 0.101);  // requested during the step
        run_until(simulation, 0.15);
    };
    Simulation whole(before, make_plan(before)), again(before, make_plan(before));
    half_way(whole), half_way(again);
    const std::string saved = state_of(whole);
    CHECK(state_of(again) == saved);
    CHECK(whole.world().solids.all[0].pose.translation.x() == Approx(0.0101).epsilon(1e-5));  // it continued from its position at that time
    run_until(whole, 0.2);

    CHECK(resumed_to(0.2, saved, before, after, 0.101) == state_of(whole));
}

}  // namespace change_test

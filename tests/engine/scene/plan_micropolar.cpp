#include <catch2/catch.hpp>

#include "engine/scene/plan.h"
#include "tests/support/poured_honey.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using test::choice;
using test::scene_with;

namespace {

/// A periodic box of fluid with a micropolar model.
const std::string eddies = test::text::time(1) +
                           test::text::domain({0, 0, 0}, {1, 1, 1}, "periodic = [true, true, true]\ngravity = [0, 0, 0]") +
                           test::text::fluid(0.05, 4) + test::text::models("") + "micropolar = \"notes\"\n" +
                           test::text::block({0, 0, 0}, {1, 1, 1}, "velocity = [\"sin(2*pi*x)\", \"0\", \"0\"]");

std::string eddy_messages(const std::vector<std::string>& changes) { return test::messages_with(changes, eddies); }

}  // namespace

TEST_CASE("micropolar systems differ in viscosity and coupling, and long waves feel nu minus half of nu_r", "[plan][micropolar]") {
    const auto numbers = [](const std::string& model) {
        return make_plan(
                   scene_with({"models.micropolar=" + model, "micropolar.transfer_viscosity=2", "micropolar.micro_inertia=0.01"}, eddies))
            .spin;
    };
    CHECK(numbers("notes").viscosity == Approx(4));
    CHECK(numbers("notes").coupling == Approx(6));
    CHECK(numbers("bender").viscosity == Approx(4));
    CHECK(numbers("bender").coupling == Approx(2));
    CHECK(numbers("eringen").viscosity == Approx(6));
    CHECK(numbers("eringen").coupling == Approx(2));
    CHECK(numbers("notes").effective_viscosity() == Approx(1));
    CHECK(numbers("notes").response_time() == Approx(0.01 * 1000 / 12));
    CHECK(numbers("notes").spin_viscosity == Approx(4 * 0.05 * 0.05));
    CHECK(numbers("notes").spin_length() == Approx(std::sqrt(4 * 0.01 / (6 * 2))));
}

TEST_CASE("a calibrated micropolar fluid has the requested viscosity and spin length in every system", "[plan][micropolar]") {
    std::string text = eddies;
    text.replace(text.find("viscosity = 4\n"), 14, "");
    for (const std::string model : {"notes", "bender", "eringen"}) {
        INFO(model);
        const Plan plan =
            make_plan(scene_with({"models.micropolar=" + model, "micropolar.effective_viscosity=3", "micropolar.spin_length=0.1"}, text));
        CHECK(plan.spin.effective_viscosity() == Approx(3));
        CHECK(plan.spin.spin_length() == Approx(0.1));
        CHECK(plan.spin.coupling == Approx(plan.spin.viscosity));
        CHECK(plan.spin.pair_viscosity == Approx(plan.spin.coupling));
        CHECK(choice(plan, "micropolar.micro_inertia").reason.find("calibrated") != std::string::npos);
    }
}

TEST_CASE("a micropolar system that gains energy is an error by default, and a warning if it was requested", "[plan][micropolar]") {
    const std::string by_default = eddy_messages({"fluid.viscosity=0.001"});
    CHECK_THAT(by_default, Catch::Contains("models.micropolar = \"notes\" would add energy: its coupling, fluid.viscosity + the default "
                                           "micropolar.transfer_viscosity = 0.3 Pa s, "
                                           "is more than twice the 0.001 Pa s that models.viscosity = \"explicit\" applies"));
    const Plan asked = make_plan(scene_with({"micropolar.transfer_viscosity=5", "micropolar.micro_inertia=0.01"}, eddies));
    REQUIRE(asked.warnings.size() == 1);
    CHECK_THAT(
        asked.warnings[0],
        Catch::Contains(
            "coupling 9 Pa s is more than twice its viscosity 4 Pa s, so slow flows have an effective viscosity of -0.5 Pa s, and waves "
            "longer than 0.419 m grow"));
    CHECK(make_plan(scene_with({"models.micropolar=eringen", "micropolar.transfer_viscosity=500", "micropolar.micro_inertia=0.01"}, eddies))
              .warnings.empty());
    CHECK_THAT(make_plan(scene_with({}, eddies)).warnings[0],
               Catch::Contains("the response time of the spin is 233 s, longer than the run of 1 s"));
}

TEST_CASE("the plan warns of a transfer viscosity that the source of the system notes excludes", "[plan][micropolar]") {
    const auto warned = [](const std::vector<std::string>& changes) {
        return test::warnings_with(make_plan(scene_with(changes, eddies)), "the source of \"notes\" uses less than 0.4");
    };
    CHECK(warned({"micropolar.transfer_viscosity=0.4"}));
    CHECK_FALSE(warned({"micropolar.transfer_viscosity=0.399"}));
    CHECK_FALSE(warned({"micropolar.transfer_viscosity=0.4", "models.micropolar=eringen"}));
}

TEST_CASE("invalid micropolar keys are refused", "[plan][micropolar]") {
    for (const auto& [changes, part] : std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"micropolar.micro_inertia=0"}, "micropolar.micro_inertia"},
             {{"micropolar.transfer_viscosity=-1"}, "micropolar.transfer_viscosity"},
             {{"fluid.viscosity=1+x"}, "fluid.viscosity varies, and a micropolar model couples flow and spin by one viscosity"},
             {{"micropolar.effective_viscosity=1"}, "fluid.viscosity is chosen by micropolar.effective_viscosity; remove one of them"},
             {{"models.pressure=coupled"}, "models.pressure = \"coupled\" has no micropolar terms"},
             {{"models.micropolar=none", "viscosity.laplacian=split", "models.viscosity=explicit"},
              "splits by the coupling of a micropolar model"},
             {{"viscosity.laplacian=split", "micropolar.transfer_viscosity=5"},
              "viscosity.laplacian = \"split\" leaves -0.5 Pa s for the strain (viscosity 4 minus half of the coupling 9), which "
              "adds energy"}}) {
        CAPTURE(changes);
        CHECK_THAT(eddy_messages(changes), Catch::Contains(part));
    }
    const std::string surface = "block[0].max=[1,0.5,1]", form = "viscosity.laplacian=brookshaw";
    CHECK_THAT(eddy_messages({surface, form, "micropolar.transfer_viscosity=3", "micropolar.micro_inertia=1e-3", "time.end=100"}),
               Catch::Contains("in the run; use viscosity.laplacian = \"split\" or \"auto\""));
    CHECK_THAT(eddy_messages({surface, "micropolar.curl_velocity=symmetric", "micropolar.curl_spin=difference"}),
               Catch::Contains("use curl_velocity = \"difference_own_density\" with curl_spin = \"symmetric\""));
    CHECK_THAT(eddy_messages({surface, "pressure.gradient=difference"}), Catch::Contains("\"difference\" does not hold a free surface"));
    CHECK(eddy_messages({"viscosity.laplacian=split", "models.micropolar=eringen"}) == "no error");
    CHECK_THAT(eddy_messages({"models.micropolar=none", "block[0].spin=[0,0,1]"}),
               Catch::Contains("block[0].spin needs a micropolar model"));
}

TEST_CASE("fluid that can rotate freely splits viscosity and coupling without a net torque", "[plan][micropolar]") {
    const auto numbers = [](std::vector<std::string> changes) {
        changes.insert(changes.begin(), {"models.viscosity=explicit", "block[0].max=[1,0.5,1]", "micropolar.micro_inertia=1e-3"});
        return make_plan(scene_with(changes, eddies)).spin;
    };
    const MicropolarNumbers half = numbers({"micropolar.transfer_viscosity=2"});  // viscosity 4, coupling 6
    CHECK(half.pair_viscosity == Approx(2));
    CHECK(half.composed_coupling == Approx(4));
    CHECK(half.central_viscosity == 0);
    const MicropolarNumbers less = numbers({"micropolar.transfer_viscosity=2", "models.micropolar=eringen"});  // viscosity 6, coupling 2
    CHECK(less.pair_viscosity == Approx(2));
    CHECK(less.composed_coupling == 0);
    CHECK(less.central_viscosity == Approx(4));
    const MicropolarNumbers implicit = numbers({"micropolar.transfer_viscosity=2", "models.viscosity=full"});
    CHECK(implicit.composed_coupling == Approx(6));
    CHECK(implicit.implicit_share == Approx(0.25));
    CHECK(numbers({"fluid.viscosity=0.4", "micropolar.transfer_viscosity=0.2", "models.viscosity=full"}).implicit_share == Approx(0.25));
    CHECK(numbers({"micropolar.transfer_viscosity=2", "block[0].max=[1,1,1]"}).pair_viscosity == Approx(4));
}

TEST_CASE("the exchange is explicit if its stable step is long enough, else implicit", "[plan][micropolar]") {
    const auto scheme = [](const std::string& theta) {
        return choice(make_plan(scene_with({"micropolar.transfer_viscosity=2", "micropolar.micro_inertia=" + theta}, eddies)),
                      "micropolar.exchange")
            .value;
    };
    CHECK(scheme("0.1") == "explicit");
    CHECK(scheme("1e-6") == "implicit");
}

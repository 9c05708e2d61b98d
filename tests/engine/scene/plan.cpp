#include "engine/scene/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "tests/support/poured_honey.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch.h"

using namespace whorl;
using test::choice;
using test::messages_with;
using test::plan_with;
using test::scene_with;
using test::warnings_with;

TEST_CASE("thick honey with a free surface is solved with its pressure, and the reason has the viscous number", "[plan]") {
    const Plan plan = plan_with({});
    CHECK(plan.pressure == PressureModel::coupled);
    CHECK(plan.viscosity == ViscosityModel::none);
    CHECK(plan.boundary == BoundaryModel::none);
    CHECK(plan.shifting == ShiftingModel::fickian);
    CHECK(plan.kernel == KernelKind::wendland_c2);
    CHECK(plan.support == Approx(4.8e-3));
    CHECK(choice(plan, "models.pressure").automatic);
    CHECK(choice(plan, "models.pressure").reason.find("nu dt/d^2 = ") != std::string::npos);
    // pi (5 mm)^2 0.25 m/s 4 s / (2 mm)^3
    CHECK(plan.estimated_particles == Approx(9817).epsilon(0.01));
    // fall from 0.08 m to the domain's floor at -0.01 m
    CHECK(plan.expected_speed == Approx(std::sqrt(0.25 * 0.25 + 2 * 9.81 * 0.09)));
    CHECK(plan.warnings.empty());
}

TEST_CASE("thick honey that fills its gap is solved with its pressure, and the reason names no free surface", "[plan]") {
    const std::string gap =
        test::text::time(1) + test::text::domain({-0.03, -0.02, -0.03}, {0.03, 0.06, 0.03}, "periodic = [true, false, true]") +
        test::text::fluid(5e-3, 100) + test::text::block({-0.03, 0, -0.03}, {0.03, 0.04, 0.03}) + test::text::plane({0, 0, 0}, {0, 1, 0}) +
        "[[solid]]\nshape = \"plane\"\nnormal = [0, -1, 0]\nposition = [\"0.1*t\", \"0.04\", \"0\"]\n";
    const Plan plan = make_plan(scene_with({}, gap));
    CHECK(plan.pressure == PressureModel::coupled);
    CHECK(choice(plan, "models.pressure").reason.find("free surface") == std::string::npos);
}

TEST_CASE("a solid that moves through the lid of a container is a warning", "[plan]") {
    const auto warnings = [&](double height) {
        const std::string text = test::text::time(1) + test::text::domain({-0.3, -0.1, -0.3}, {0.3, 0.9, 0.3}) + test::text::fluid(0.01) +
                                 test::text::block({-0.1, 0, -0.1}, {0.1, 0.05, 0.1}) +
                                 test::text::tank({-0.1, 0, -0.1}, {0.1, height, 0.1}) +
                                 "[[solid]]\nshape = \"sphere\"\nradius = 0.02\nposition = [\"0\", \"0.1+0.2*t\", \"0\"]\n";
        return warnings_with(make_plan(scene_with({}, text)), "closed on all sides");
    };
    CHECK(warnings(0.2) == 1);  // the sphere reaches .32 m
    CHECK(warnings(0.4) == 0);
}

TEST_CASE("a thinner fluid is solved with its pressure down to a viscous number of a quarter", "[plan]") {
    const auto with_number = [](double number) {  // nu = number d^2/dt, dt = 0.4 d/speed
        const double d = 2e-3, speed = std::sqrt(0.25 * 0.25 + 2 * 9.81 * 0.09);
        return plan_with({"fluid.viscosity=" + std::to_string(1000 * number * d * speed / 0.4)}).pressure;
    };
    CHECK(with_number(0.3) == PressureModel::coupled);
    CHECK(with_number(0.2) == PressureModel::ppe);
}

TEST_CASE("the viscous number of a fluid with a flow law is that of the shear across its narrowest feature", "[plan]") {
    // A heap of mayonnaise 25 spacings wide: where the speed changes over its width, 20 + 50 (speed/0.06 m)^0.5 over that rate.
    const std::string heap = test::text::time(1) + test::text::domain({-0.1, -0.02, -0.1}, {0.1, 0.12, 0.1}) +
                             "[fluid]\nspacing = 2.4e-3\nyield_stress = 20\nconsistency = 50\nflow_index = 0.5\n" +
                             test::text::block({-0.03, 0, -0.03}, {0.03, 0.06, 0.03}) + test::text::plane({0, 0, 0}, {0, 1, 0});
    const Plan plan = make_plan(scene_with({}, heap));
    const double rate = plan.expected_speed / 0.06;
    CHECK(plan.largest_viscosity == Approx(20 / rate + 50 / std::sqrt(rate)).epsilon(0.01));
    CHECK(plan.pressure == PressureModel::coupled);
}

TEST_CASE("the coupled solve refuses a viscous number below 0.04 anywhere at the start, with a fix", "[plan]") {
    const double d = 2e-3, speed = std::sqrt(0.25 * 0.25 + 2 * 9.81 * 0.09);
    const auto with_number = [&](double number) { return std::to_string(1000 * number * d * speed / 0.4); };
    const auto coupled = [](const std::string& viscosity) {
        return messages_with({"models.pressure=coupled", "fluid.viscosity=" + viscosity});
    };
    CHECK(coupled(with_number(0.05)) == "no error");
    CHECK_THAT(coupled(with_number(0.03)),
               Catch::Contains("too thin for models.pressure = \"coupled\": the viscous number nu dt/d^2 is 0.03 "));
    CHECK_THAT(coupled("0.001"),
               Catch::Contains("fluid.viscosity=0.001: fluid.viscosity is 0.001 Pa s at the start, too thin for models.pressure = "
                               "\"coupled\""));
    CHECK_THAT(coupled("0.001"),
               Catch::Contains("coupled needs at least 0.04; choose models.pressure = \"ppe\" with models.viscosity = \"full\""));
    CHECK(coupled("0").find("too thin") != std::string::npos);
    // The minimum at the start decides, whatever it becomes later.
    CHECK(coupled("100*age").find("too thin") != std::string::npos);
    CHECK(coupled("100*exp(-age)") == "no error");
    CHECK_THAT(messages_with({"models.pressure=coupled", "emitter[0].viscosity=0.001"}),
               Catch::Contains("emitter[0].viscosity is 0.001 Pa s"));
    // The plan does not choose it if a part of the fluid is thin.
    CHECK(plan_with({"fluid.viscosity=0.001+1000*age"}).pressure == PressureModel::ppe);
}

TEST_CASE("the plan warns if spinning fluid rises above the rim or the domain", "[plan]") {
    const auto warned = [](double lid, double top, const std::string& what) {
        const auto cylinder = [](const char* table, double height) {
            return fmt::format("[[{}]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, {}, 0]\nradius = 0.048\n", table, height);
        };
        const std::string text = test::text::time(1) + test::text::domain({-0.06, -0.01, -0.06}, {0.06, top, 0.06}) +
                                 test::text::fluid(6e-3) + cylinder("block", 0.036) + cylinder("solid", lid) +
                                 "container = true\nrotation = [0, \"20*min(t, 1)\", 0]\n";
        return warnings_with(make_plan(scene_with({}, text)), "solid[0] turns at 20 rad/s: fluid that turns with it " + what);
    };
    const std::string past = "climbs to 0.0595 m, and the vessel or the domain ends at 0.055 m";  // .036 + 20^2 .048^2/(4 g)
    CHECK_FALSE(warned(0.062, 0.12, "climbs to"));
    CHECK(warned(0.055, 0.12, past));
    CHECK(warned(0.12, 0.055, past));
}

TEST_CASE("the user's choices are kept, including kernel and support", "[plan]") {
    const Plan plan = plan_with({"fluid.kernel=cubic", "fluid.support=2.5"});
    CHECK(plan.kernel == KernelKind::cubic);
    CHECK(plan.support == Approx(5e-3));
    CHECK_FALSE(choice(plan, "fluid.support").automatic);
}

TEST_CASE("water gets the pressure equation and explicit viscosity, an inviscid fluid no viscosity", "[plan]") {
    const Plan water = plan_with({"fluid.viscosity=0.001"});
    CHECK(water.pressure == PressureModel::ppe);
    CHECK(water.viscosity == ViscosityModel::explicit_laplacian);
    CHECK(water.boundary == BoundaryModel::ppe);
    CHECK(water.shifting == ShiftingModel::none);
    CHECK(water.support == Approx(4e-3));
    CHECK(plan_with({"fluid.viscosity=0"}).viscosity == ViscosityModel::none);
}

TEST_CASE("thick fluid without a free surface, or with another pressure, gets the full implicit viscosity", "[plan]") {
    const Plan closed = plan_with({"fluid.spacing=4e-3", "domain.periodic=[true,true,true]", "domain.gravity=[0,0,0]",
                                   "solid[0].shape=sphere", "solid[0].radius=0.01"});
    CHECK(closed.pressure == PressureModel::ppe);
    CHECK(closed.viscosity == ViscosityModel::full);
    CHECK(plan_with({"models.pressure=ppe"}).viscosity == ViscosityModel::full);
}

TEST_CASE("weakly compressible sound is ten times the expected speed, and solids act by their volumes", "[plan]") {
    const Plan plan = plan_with({"models.pressure=wcsph", "fluid.viscosity=0.1"});
    CHECK(plan.boundary == BoundaryModel::akinci);
    CHECK(plan.sound_speed == Approx(10 * plan.expected_speed));
    CHECK(plan_with({"models.pressure=wcsph", "fluid.viscosity=0.1", "pressure.sound_speed=20"}).sound_speed == 20);
}

TEST_CASE("auto chooses full viscosity if fluid can rotate freely, and the plan warns of explicit", "[plan]") {
    const std::string turning = test::text::time(1) + test::text::domain({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, "gravity = [0, 0, 0]") +
                                test::text::fluid(4e-3, 0.05) + test::text::models("wcsph") +
                                "[[block]]\nshape = \"cylinder\"\nfrom = [0, 0, -0.02]\nto = [0, 0, 0.02]\nradius = 0.03\n"
                                "velocity = [\"-9*y\", \"9*x\", \"0\"]\n";
    const auto plan_of = [&](const std::vector<std::string>& changes) { return make_plan(scene_with(changes, turning)); };
    const auto warned = [&](const std::vector<std::string>& changes) { return warnings_with(plan_of(changes), "of the rotation"); };
    CHECK(plan_of({}).viscosity == ViscosityModel::full);
    CHECK(plan_of({"fluid.viscosity=0.001"}).viscosity == ViscosityModel::explicit_laplacian);  // hardly one turn
    CHECK(plan_of({"viscosity.laplacian=monaghan"}).viscosity == ViscosityModel::explicit_laplacian);
    CHECK(warned({"models.viscosity=explicit"}));
    CHECK_FALSE(warned({"models.viscosity=explicit", "viscosity.laplacian=monaghan"}));
    CHECK_FALSE(warned({}));
}

TEST_CASE("viscosity that varies in space counts with its largest value", "[plan]") {
    CHECK(plan_with({"fluid.viscosity=y > 0.07 ? 5 : 1"}).largest_viscosity == 5);
    CHECK(plan_with({"emitter[0].start=3", "fluid.viscosity=1000 + 100*age"}).largest_viscosity == Approx(1100));
}

TEST_CASE("thick fluid that lies on a floor counts in the choice of models", "[plan]") {
    const std::string scene = test::text::time(0.1) + test::text::domain({0, -0.1, 0}, {1, 1, 1}) +
                              test::text::fluid(0.025, 0, "viscosity = \"y < 0.05 ? 100 : 0.001\"") +
                              test::text::plane({0, 0, 0}, {0, 1, 0}) + test::text::block({0.2, 0, 0.2}, {0.8, 0.4, 0.8});
    CHECK(make_plan(scene_with({}, scene)).largest_viscosity == Approx(100));
}

TEST_CASE("a block's viscosity counts even if no sample point lies in it", "[plan]") {
    const test::ScratchFolder folder;  // two separate parts in opposite corners
    std::ofstream(folder / "two.obj") << "v 0 8 8\nv 8 0 8\nv 8 8 0\nv 8 8 8\nv 40 32 32\nv 32 40 32\nv 32 32 40\nv 32 32 32\n"
                                         "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\nf 5 6 7\nf 5 8 6\nf 6 8 7\nf 7 8 5\n";
    const std::string scene = test::poured_honey, block = "[[block]]\nshape = \"mesh\"\nscale = 1e-3\nfile = \"";
    for (const std::string viscosity : {"1000", "1000 + 0*x"}) {
        const std::string text = scene.substr(0, scene.find("[[emitter]]")) + block + (folder / "two.obj").string() + "\"\n";
        CHECK(make_plan(scene_with({"fluid.viscosity=" + viscosity}, text)).pressure == PressureModel::coupled);
    }
}

TEST_CASE("few particles across the opening are a warning", "[plan]") {
    const Plan plan = plan_with({"fluid.spacing=4e-3"});
    REQUIRE(plan.warnings.size() == 1);
    CHECK(plan.warnings[0] == "only 2.5 particles across emitter[0]: details there are lost, use a smaller fluid.spacing");
}

TEST_CASE("a block that overlaps a solid is a warning, one on it or filling its container is not", "[plan]") {
    const auto warnings = [](const std::string& block) { return plan_with({"block[0]={shape=\"box\", " + block + "}"}).warnings; };
    CHECK(warnings("min=[-0.004,0,-0.004], max=[0.004,0.01,0.004]")
              .empty());  // a layer of a fifth is nearer to the plane than half a spacing
    const auto found = warnings("min=[-0.02,-0.005,-0.02], max=[0.02,0.005,0.02]");
    REQUIRE(found.size() == 1);
    CHECK(found[0].find("% of block[0] lies inside solids and is left out") != std::string::npos);
}

TEST_CASE("blocks that overlap are a warning with the part that overlaps, blocks that meet are not", "[plan]") {
    const auto warnings = [](const std::string& top) {
        return plan_with({"block[0]={shape=\"box\", min=[-0.02,0,-0.02], max=[0.02,0.02,0.02]}",
                          "block[1]={shape=\"box\", min=[-0.02," + top + ",-0.02], max=[0.02,0.04,0.02]}"})
            .warnings;
    };
    CHECK(warnings("0.02").empty());
    const auto found = warnings("0.01");
    REQUIRE(found.size() == 1);
    CHECK(found[0].find("% of block[1] lies inside block[0]") != std::string::npos);
}

TEST_CASE("the plan warns of a force of unknown speed if the sound must be faster", "[plan]") {
    const auto warned = [](const std::vector<std::string>& changes) {
        return warnings_with(plan_with(changes), "without the speeds that fluid.force causes");
    };
    CHECK(warned({"fluid.force=[1,0,0]", "models.pressure=wcsph"}));
    CHECK_FALSE(warned({"fluid.force=[1,0,0]", "models.pressure=wcsph", "pressure.sound_speed=20"}));
    CHECK_FALSE(warned({"fluid.force=[1,0,0]"}));
}

TEST_CASE("the plan of the assembled viscosity reports the memory of its matrix", "[plan]") {
    const Plan plan = plan_with({"models.viscosity=full_assembled", "models.pressure=ppe"});
    // 251 lattice points nearer than four spacings, each nine numbers and an index.
    CHECK_THAT(choice(plan, "viscosity matrix").reason,
               Catch::Contains(sizeof(Real) == 4 ? "10.0 kB per particle" : "19.1 kB per particle"));
}

TEST_CASE("the plan warns of monaghan with few neighbours, with its stiffness on a lattice", "[plan]") {
    const auto warned = [](const std::string& support) {
        return warnings_with(
            plan_with({"models.viscosity=explicit", "viscosity.laplacian=monaghan", "models.pressure=ppe", "fluid.support=" + support}),
            "times as stiff");
    };
    CHECK(warned("2"));
    CHECK_FALSE(warned("4"));
}

TEST_CASE("the constraint is a warning in fluid that fills its space, unless a body moves in it", "[plan][pressure]") {
    const auto warned = [](const std::string& more, double top = 0.2) {
        return warnings_with(make_plan(scene_with({}, test::text::time(1) + test::text::domain({-0.1, -0.1}, {0.3, 0.3}) +
                                                          test::text::fluid(0.01, 1) + "[models]\nviscosity = \"full\"\n" + more +
                                                          test::text::block({0, 0}, {0.2, top}) + test::text::tank({0, 0}, {0.2, 0.2}))),
                             "takes energy from vortices");
    };
    const std::string constraint = "[pressure]\nform = \"constraint\"\n";
    CHECK(warned("") == 0);
    CHECK(warned(constraint) == 1);
    CHECK(warned(constraint, 0.1) == 0);
    CHECK(warned(constraint + test::text::ball({0.1, 0.1}, 0.03, "density = 2000")) == 0);
}

TEST_CASE("a background pressure is a warning if blocks leave room, not in a full channel", "[plan]") {
    const auto channel = [](double top) {
        return make_plan(
            scene_with({}, test::text::time(1) + test::text::domain({0, -0.01, 0}, {0.2, 0.11, 0.1}, "periodic = [true, false, true]") +
                               test::text::fluid(0.01) + test::text::models("wcsph") + "[pressure]\nbackground_pressure = 100\n" +
                               test::text::block({0, 0, 0}, {0.2, top, 0.1}) + test::text::box({-0.1, -0.02, -0.1}, {0.3, 0, 0.2}) +
                               test::text::box({-0.1, 0.1, -0.1}, {0.3, 0.12, 0.2})));
    };
    CHECK(warnings_with(channel(0.1), "background_pressure") == 0);
    CHECK(warnings_with(channel(0.05), "background_pressure") == 1);
}

TEST_CASE("the projection is chosen if fluid fills its space, and is a warning if it has a surface", "[plan][pressure]") {
    const std::string start = test::text::time(1) + test::text::domain({-0.1, -0.1, -0.1}, {1, 1, 0.3}) + test::text::fluid(0.01),
                      projection = test::text::pressure_form("projection"), tank = test::text::tank({0, 0, 0}, {0.4, 0.4, 0.2});
    const auto block = [](const char* max) { return std::string("[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = ") + max + "\n"; };
    const auto message = [&](const std::string& text) { return messages_with({}, start + text); };
    const auto warnings = [&](const std::string& text) { return make_plan(scene_with({}, start + text)).warnings; };
    CHECK(warnings(projection + tank + block("[0.4, 0.4, 0.2]")).empty());
    REQUIRE(warnings(projection + tank + block("[0.4, 0.2, 0.2]")).size() == 1);
    CHECK_THAT(warnings(projection + tank + block("[0.4, 0.2, 0.2]"))[0],
               Catch::Contains("it diverges or loses volume if a column collapses"));
    CHECK(message("surface_tension = 0.1\n" + projection + tank + block("[0.4, 0.2, 0.2]")) == "no error");
    CHECK_THAT(message("surface_tension = 0.1\n" + projection + tank + block("[0.2, 0.2, 0.2]")),
               Catch::Contains("fluid that covers a solid in part"));
    CHECK_THAT(message(projection + tank + block("[0.4, 0.2, 0.2]") +
                       "[[solid]]\nshape = \"sphere\"\nposition = [0.2, 0.1, 0.1]\nradius = 0.05\n"),
               Catch::Contains("diverges next to a solid in the fluid, such as solid[1]"));
    CHECK_THAT(message("surface_tension = 0.1\n" + projection + tank + "wetting = 0.75\n" + block("[0.4, 0.2, 0.2]")),
               Catch::Contains("a surface meets solids at 90 degrees"));
    const auto drop = [&](const std::string& pressure, double wetting, const std::string& slip = "no") {
        return message("surface_tension = 0.1\nviscosity = 10\n[models]\npressure = \"" + pressure + "\"\n" + tank +
                       fmt::format("wetting = {}\nslip = \"{}\"\n", wetting, slip) + block("[0.4, 0.2, 0.2]"));
    };
    CHECK(drop("ppe", 0.9) == "no error");
    CHECK(drop("ppe", 0.5, "free") == "no error");
    CHECK(drop("coupled", 0.1) == "no error");
    CHECK(drop("auto", 0.9) == "no error");
    CHECK(drop("auto", 0.5, "free") == "no error");
    CHECK_THAT(drop("wcsph", 0.5), Catch::Contains("drops do not meet the solid at the angle of wetting = 0.5"));
    CHECK_THAT(drop("coupled", 0.9), Catch::Contains("\"coupled\", drops do not meet the solid at the angle of wetting = 0.9"));
    CHECK_THAT(drop("coupled", 0.5, "free"), Catch::Contains("\"coupled\" and a slip other than \"no\", drops"));
    const auto form = [&](const std::string& text) { return make_plan(scene_with({}, start + text)).traits.pressure.form; };
    CHECK(form(tank + block("[0.4, 0.4, 0.2]")) == PressureForm::projection);
    CHECK(form(tank + block("[0.4, 0.2, 0.2]")) == PressureForm::constraint);
    CHECK(choice(make_plan(scene_with({}, start + tank + block("[0.4, 0.4, 0.2]"))), "pressure.form").automatic);
    CHECK_FALSE(choice(make_plan(scene_with({}, start + projection + tank + block("[0.4, 0.4, 0.2]"))), "pressure.form").automatic);
}

TEST_CASE("in 2D the plan counts particles by area, and refuses by name keys that exist only in 3D", "[plan][plane]") {
    const std::string tank = test::text::time(1) + test::text::domain({-0.1, -0.1}, {0.3, 0.3}) + test::text::fluid(0.01, 100) +
                             test::text::block({0, 0}, {0.2, 0.1}) + test::text::tank({0, 0}, {0.2, 0.2});
    const Plan plan = make_plan(scene_with({}, tank));
    CHECK(plan.estimated_particles == Approx(200));
    CHECK(plan.particle_volume() == Approx(1e-4));
    CHECK(plan.pressure == PressureModel::coupled);
    CHECK(plan.kernel.dimensions == 2);
    CHECK(plan.support == Approx(0.024));

    const auto messages = [&](const std::string& change) { return messages_with({change}, tank); };
    const std::string here = " in two dimensions (domain.dimensions = 2)";
    CHECK(messages("fluid.surface_tension=0.07").find("cohesion between particles is not supported" + here) != std::string::npos);
    CHECK(messages("output.export=[\"vdb\"]").find("no surface exists to export as \"vdb\"" + here) != std::string::npos);
}

TEST_CASE("a vessel counts as turning if fluid climbs in it by more than a spacing", "[plan]") {
    const auto vessel = [](double climb) {  // spacings
        const double rate = std::sqrt(2 * 9.81 * climb * 6e-3) / 0.048;
        return make_plan(
                   scene_with({}, test::text::time(1) + test::text::domain({-0.06, -0.01, -0.06}, {0.06, 0.12, 0.06}) +
                                      test::text::fluid(6e-3) + "[[solid]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\n" +
                                      fmt::format("to = [0, 0.1, 0]\nradius = 0.048\ncontainer = true\nrotation = [0, {}, 0]\n", rate) +
                                      "[[block]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, 0.036, 0]\nradius = 0.048\n"))
            .turning_vessel;
    };
    CHECK(vessel(0.9) == -1);
    CHECK(vessel(1.1) == 0);
}

TEST_CASE("a solid lighter than the fluid is a warning with the projection if it has weight at the start", "[plan][pressure]") {
    const auto warned = [](const std::string& gravity) {
        const std::string text = test::text::time(1) + test::text::domain({-0.1, -0.1, -0.1}, {0.5, 0.5, 0.3}) + test::text::fluid(0.01) +
                                 test::text::pressure_form("projection") + test::text::block({0, 0, 0}, {0.4, 0.4, 0.2}) +
                                 test::text::tank({0, 0, 0}, {0.4, 0.4, 0.2}) +
                                 "[[solid]]\nshape = \"sphere\"\nposition = [0.2, 0.2, 0.1]\nradius = 0.05\ndensity = 500\n";
        const std::vector<std::string> all = make_plan(scene_with({"domain.gravity=[0, \"" + gravity + "\", 0]"}, text)).warnings;
        return std::any_of(all.begin(), all.end(), [](const auto& w) { return w.find("solid[1] is lighter than the fluid") == 0; });
    };
    CHECK(warned("-9.81*(1-t)"));
    CHECK_FALSE(warned("-9.81*t"));
}

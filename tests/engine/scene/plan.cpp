#include "engine/scene/plan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "engine/scene/write.h"
#include "tests/support/poured_honey.h"
#include "tests/support/scratch.h"

using namespace whorl;
using test::messages_with;
using test::plan_with;
using test::scene_with;

namespace {

const Choice& choice(const Plan& plan, const std::string& key) {
    for (const Choice& c : plan.choices)
        if (c.key == key) return c;
    FAIL("no choice of " + key);
    return plan.choices.front();
}

}  // namespace

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

TEST_CASE("a thinner fluid is solved with its pressure down to a viscous number of a quarter", "[plan]") {
    const auto with_number = [](double number) {  // nu = number d^2/dt, dt = 0.4 d/speed
        const double d = 2e-3, speed = std::sqrt(0.25 * 0.25 + 2 * 9.81 * 0.09);
        return plan_with({"fluid.viscosity=" + std::to_string(1000 * number * d * speed / 0.4)}).pressure;
    };
    CHECK(with_number(0.3) == PressureModel::coupled);
    CHECK(with_number(0.2) == PressureModel::ppe);
}

TEST_CASE("the coupled solve refuses fluid whose viscous number is below 0.04 anywhere at the start, with what to choose", "[plan]") {
    const double d = 2e-3, speed = std::sqrt(0.25 * 0.25 + 2 * 9.81 * 0.09);
    const auto with_number = [&](double number) { return std::to_string(1000 * number * d * speed / 0.4); };
    const auto coupled = [](const std::string& viscosity) {
        return messages_with({"models.pressure=coupled", "fluid.viscosity=" + viscosity});
    };
    CHECK(coupled(with_number(0.05)) == "no error");
    CHECK(coupled(with_number(0.03)).find("too thin for models.pressure = \"coupled\": the viscous number nu dt/d^2 is 0.03 ") !=
          std::string::npos);
    CHECK(coupled("0.001").find("fluid.viscosity=0.001: fluid.viscosity is 0.001 Pa s at the start, too thin for models.pressure = "
                                "\"coupled\"") != std::string::npos);
    CHECK(coupled("0.001").find("coupled works from 0.04 on; choose models.pressure = \"ppe\" with models.viscosity = \"full\"") !=
          std::string::npos);
    CHECK(coupled("0").find("too thin") != std::string::npos);
    // By the least at the start, whatever it becomes.
    CHECK(coupled("100*age").find("too thin") != std::string::npos);
    CHECK(coupled("100*exp(-age)") == "no error");
    CHECK(messages_with({"models.pressure=coupled", "emitter[0].viscosity=0.001"}).find("emitter[0].viscosity is 0.001 Pa s") !=
          std::string::npos);
    // Left to choose, it is not taken where a part of the fluid is thin.
    CHECK(plan_with({"fluid.viscosity=0.001+1000*age"}).pressure == PressureModel::ppe);
}

TEST_CASE("what the user chose stays, also the kernel and its support", "[plan]") {
    const Plan plan = plan_with({"fluid.kernel=cubic", "fluid.support=2.5"});
    CHECK(plan.kernel == KernelKind::cubic);
    CHECK(plan.support == Approx(5e-3));
    CHECK_FALSE(choice(plan, "fluid.support").automatic);
}

TEST_CASE("water takes the pressure equation and explicit viscosity, a dry fluid none", "[plan]") {
    const Plan water = plan_with({"fluid.viscosity=0.001"});
    CHECK(water.pressure == PressureModel::ppe);
    CHECK(water.viscosity == ViscosityModel::explicit_laplacian);
    CHECK(water.boundary == BoundaryModel::ppe);
    CHECK(water.shifting == ShiftingModel::none);
    CHECK(water.support == Approx(4e-3));
    CHECK(plan_with({"fluid.viscosity=0"}).viscosity == ViscosityModel::none);
}

TEST_CASE("thick fluid without a free surface, or with another pressure, gets the full implicit viscosity", "[plan]") {
    const std::vector<std::string> closed = {"domain.periodic=[true,true,true]", "domain.gravity=[0,0,0]"};
    CHECK(plan_with(closed).pressure == PressureModel::ppe);
    CHECK(plan_with(closed).viscosity == ViscosityModel::full);
    CHECK(plan_with({"models.pressure=ppe"}).viscosity == ViscosityModel::full);
}

TEST_CASE("weakly compressible sound is ten times the expected speed, and solids act by their volumes", "[plan]") {
    const Plan plan = plan_with({"models.pressure=wcsph", "fluid.viscosity=0.1"});
    CHECK(plan.boundary == BoundaryModel::akinci);
    CHECK(plan.sound_speed == Approx(10 * plan.expected_speed));
    CHECK(plan_with({"models.pressure=wcsph", "fluid.viscosity=0.1", "pressure.sound_speed=20"}).sound_speed == 20);
}

TEST_CASE(
    "where the Laplacian of each velocity component would stop a body that turns, auto takes the full viscosity, and explicit is warned of",
    "[plan]") {
    const std::string turning = R"toml([time]
end = 1
[domain]
min = [-0.1, -0.1, -0.1]
max = [0.1, 0.1, 0.1]
gravity = [0, 0, 0]
[fluid]
spacing = 4e-3
viscosity = 0.05
[models]
pressure = "wcsph"
[[block]]
shape = "cylinder"
from = [0, 0, -0.02]
to = [0, 0, 0.02]
radius = 0.03
velocity = ["-9*y", "9*x", "0"]
)toml";
    const auto plan_of = [&](const std::vector<std::string>& changes) { return make_plan(scene_with(changes, turning)); };
    const auto warned = [&](const std::vector<std::string>& changes) {
        for (const std::string& w : plan_of(changes).warnings)
            if (w.find("of its rotation") != std::string::npos) return true;
        return false;
    };
    CHECK(plan_of({}).viscosity == ViscosityModel::full);
    CHECK(plan_of({"fluid.viscosity=0.001"}).viscosity == ViscosityModel::explicit_laplacian);  // hardly a turn's worth
    CHECK(plan_of({"viscosity.laplacian=monaghan"}).viscosity == ViscosityModel::explicit_laplacian);
    CHECK(warned({"models.viscosity=explicit"}));
    CHECK_FALSE(warned({"models.viscosity=explicit", "viscosity.laplacian=monaghan"}));
    CHECK_FALSE(warned({}));
}

TEST_CASE("viscosity that varies in space counts with its largest value", "[plan]") {
    CHECK(plan_with({"fluid.viscosity=y > 0.07 ? 5 : 1"}).largest_viscosity == 5);
    CHECK(plan_with({"emitter[0].start=3", "fluid.viscosity=1000 + 100*age"}).largest_viscosity == Approx(1100));
}

TEST_CASE("thick fluid that lies on a floor counts for the models", "[plan]") {
    const std::string scene =
        "name = \"floor\"\n[time]\nend = 0.1\n[domain]\nmin = [0,-0.1,0]\nmax = [1,1,1]\n[fluid]\nspacing = 0.025\n"
        "viscosity = \"y < 0.05 ? 100 : 0.001\"\n[[solid]]\nshape = \"plane\"\n[[block]]\nshape = \"box\"\n"
        "min = [0.2,0,0.2]\nmax = [0.8,0.4,0.8]\n";
    CHECK(make_plan(scene_with({}, scene)).largest_viscosity == Approx(100));
}

TEST_CASE("the viscosity of a block counts that is at none of the points where it is looked for", "[plan]") {
    const test::ScratchFolder folder;  // two pieces in opposite corners
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
    CHECK(plan.warnings[0] == "only 2.5 particles across emitter[0]: details there are lost, take a smaller fluid.spacing");
}

TEST_CASE("a block that reaches into a solid is a warning, one that stands on it or fills its container is not", "[plan]") {
    const auto warnings = [](const std::string& block) { return plan_with({"block[0]={shape=\"box\", " + block + "}"}).warnings; };
    CHECK(warnings("min=[-0.004,0,-0.004], max=[0.004,0.01,0.004]")
              .empty());  // a layer of a fifth is nearer to the plane than half a spacing
    const auto found = warnings("min=[-0.02,-0.005,-0.02], max=[0.02,0.005,0.02]");
    REQUIRE(found.size() == 1);
    CHECK(found[0].find("% of block[0] lies inside solids and is left out") != std::string::npos);
}

TEST_CASE("impossible scenes are told with place and hint", "[plan]") {
    const std::string domain = "; the domain goes from (-0.1, -0.01, -0.1) to (0.1, 0.1, 0.1)";
    CHECK(messages_with({"emitter[0].position=[0,0.2,0]"}) ==
          "--set emitter[0].position=[0,0.2,0]: emitter[0] at (0, 0.2, 0) lies outside of the domain" + domain);
    CHECK(messages_with({"emitter[0].position=[0,-0.005,0]"}) ==
          "--set emitter[0].position=[0,-0.005,0]: emitter[0] at (0, -0.005, 0) lies 0.005 m inside solid[0]; move one of them");
    CHECK(messages_with({"fluid.spacing=0.02"}) ==
          "--set fluid.spacing=0.02: fluid.spacing = 0.02 m is larger than emitter[0], which is 0.01 m across; 0.002 m puts 5 particles "
          "across it");
    CHECK(messages_with({"emitter[0].speed=0.1-t"}).find("emitter[0].speed is -0.0") != std::string::npos);
    // Of place, too: at the start where blocks are.
    const std::string block = "block[0]={shape=\"box\", min=[0.02,0.02,0], max=[0.05,0.1,0.05]}",
                      stream = "min=[0,0,0], max=[0.1,0.1,0.1]}";
    for (const auto& [set, told] : std::vector<std::pair<std::string, std::string>>{
             {"fluid.force=[0, 0, \"1/(2-t)^0.5\"]", "fluid.force is not finite at t = 2 s"},
             {"fluid.force=[\"sqrt(-x)\", 0, 0]", "fluid.force is not finite at t = 0 s at (0.0371, 0.0632, 0.0265)"},
             {"fluid.force=[\"sqrt(x)/sqrt(x*x+z*z)\", 0, 0]", "no error"},
             {"solid[0].position=[0, \"0.01*(1-t)^0.5\", 0]", "solid[0].position is not finite at t = 1.016 s"},
             {"solid[0].rotation=[0, \"(1-t)^0.5\", 0]", "solid[0].rotation is not finite at t = 1.016 s"}})
        CHECK_THAT(messages_with({"time.end=4", block, set}), Catch::Contains(told == "no error" ? told : "--set " + set + ": " + told));
    // What a block and an opening give their particles, only where these may stand.
    const auto box = [](const std::string& keys) { return "block[0]={shape=\"box\", min=[0,0.02,0], max=[0.05,0.06,0.05], " + keys + "}"; };
    const std::string outside_ball = "sqrt((x-0.028)^2+(y-0.042)^2+(z-0.026)^2-1.4e-4)",
                      too_large = sizeof(Real) == 4 ? "1e39" : "1e300*1e300";
    for (const auto& [set, told] : std::vector<std::pair<std::string, std::string>>{
             {box("velocity=[\"y/sqrt(x^2+z^2)\",0,0]"), "no error"},
             {box("velocity=[\"sqrt(x-0.02)\",0,0]"), "block[0].velocity is not finite at ("},
             {box("spin=[\"sqrt(x-0.02)\",0,0]"), "block[0].spin is not finite at ("},
             {box("ink=[\"sqrt(x-0.02)\"]"), "block[0].ink is no number at ("},
             {"fluid.viscosity=1e3*sqrt(abs(x-0.035)-0.005)", "fluid.viscosity is nan Pa s at ("},
             {"fluid.viscosity=3000-1000*age", "block[0] at the age of 3.016 s; allowed: at least 0"},
             {"fluid.viscosity=x > 0.03 ? " + too_large + " : 1000",
              sizeof(Real) == 4 ? "in block[0]; allowed: up to 3.4e+38" : "allowed: up to"},
             {"fluid.force=[\"" + outside_ball + "\", 0, 0]", "no error"},
             {box("velocity=[\"" + outside_ball + "\",0,0]"), "no error"},
             {box("spin=[\"" + outside_ball + "\",0,0]"), "no error"},
             {box("ink=[\"" + outside_ball + "\"]"), "no error"},
             {"emitter[0].viscosity=abs(x-0.002) < 0.001 ? 0-1 : 1000",
              "emitter[0].viscosity is -1 Pa s at emitter[0]; allowed: at least 0"}})
        CHECK_THAT(messages_with({"models.pressure=ppe", "models.micropolar=bender", "emitter[0].viscosity=1000",
                                  "solid[1]={shape=\"sphere\", radius=" + std::string(told == "no error" ? "0.012" : "0.001") +
                                      ", position=[0.028,0.042,0.026]}",
                                  set.rfind("block", 0) == 0 ? set : box("velocity=[0,0,0]"), set}),
                   Catch::Contains(told));
    CHECK(messages_with({"emitter[0].viscosity=1000", box("velocity=[0,0,0]"), "fluid.viscosity=1e5*" + outside_ball,
                         "solid[1]={shape=\"sphere\", radius=0.012, position=[0.028,0.042,0.026]}"}) == "no error");
    CHECK(messages_with({"emitter[0].start=3", "emitter[0].viscosity=1100-1000*age"}) == "no error");
    CHECK_THAT(messages_with({"emitter[0].start=3", "emitter[0].viscosity=900-1000*age"}), Catch::Contains("at the age of 0.9"));
    CHECK(messages_with({"emitter[0].viscosity=1000", "fluid.viscosity=1e5*sqrt(0.000901 - (x-0.05)^2-(y-0.04)^2-(z-0.05)^2)",
                         "block[0]={shape=\"sphere\", radius=0.03, position=[0.05,0.04,0.05]}"}) == "no error");
    CHECK_THAT(messages_with({"stream[0]={velocity=[\"(0-t)^0.5\", 0, 0], time=1, " + stream}),
               Catch::Contains("stream[0].velocity is not finite at t = "));
    CHECK_THAT(messages_with({"time.end=4", "models.micropolar=bender", "micropolar.torque=[0, \"log(1-t)\", 0]"}),
               Catch::Contains("micropolar.torque is not finite at t = 1 s"));
    CHECK(messages_with({"block[0]={shape=\"box\", min=[0.2,0,0], max=[0.3,0.1,0.1]}"}).find("block[0] lies outside of the domain") !=
          std::string::npos);
    CHECK(messages_with({"block[0]={shape=\"box\", min=[0.05,0,0], max=[0.15,0.1,0.1]}"}).find("block[0] reaches out of the domain") !=
          std::string::npos);
    CHECK(messages_with({"block[0]={shape=\"box\", min=[0,-0.01,0], max=[0.1,-0.001,0.1]}"})
              .find("block[0] lies wholly inside solids; move it or the solid") != std::string::npos);
    CHECK(messages_with({"solid[1]={shape=\"sphere\", radius=0.01, position=[1,0,0]}"})
              .find("solid[1] lies outside of the domain and never enters it") != std::string::npos);
    CHECK(messages_with({"probe[0]={name=\"a\", kind=\"point\", at=[0,9,0]}"}).find("probe[0] measures outside of the domain") !=
          std::string::npos);
    CHECK(messages_with({"domain.periodic=[true,false,false]", "domain.min=[-0.004,-0.01,-0.1]", "domain.max=[0.004,0.1,0.1]"})
              .find("the periodic axis x is 0.008 m long, shorter than two support radii of 0.008 m") != std::string::npos);
    CHECK(messages_with({"models.pressure=ppe", "fluid.support=1.2", "domain.periodic=[true,false,false]", "domain.min=[-0.003,-0.01,-0.1]",
                         "domain.max=[0.003,0.1,0.1]"})
              .find("the periodic axis x is 0.006 m long, shorter than two support radii of 0.004 m") != std::string::npos);
    CHECK(messages_with({"block[0]={shape=\"cylinder\", from=[-0.09,0,-0.09], to=[0.09,0.09,0.09], radius=1e-5}", "fluid.spacing=1e-5"})
              .find("block[0] fills ") != std::string::npos);
    CHECK(messages_with({"models.pressure=ppe", "solid[1]={shape=\"sphere\", radius=1000, inside=true}"})
              .find("the surface of solid[1] takes about 3.1e+12") != std::string::npos);
    for (const auto& [y, hint] : {std::pair("0", "make the domain smaller or"), {"\"0.01*t\"", "make it move less or"}})
        CHECK_THAT(messages_with({"models.pressure=ppe", "domain.min=[-1000,-0.01,-1000]", "domain.max=[1000,0.1,1000]",
                                  "solid[0].position=[0," + std::string(y) + ",0]"}),
                   Catch::Contains(hint));
    CHECK(messages_with({"emitter[0].radius=0.09", "emitter[0].speed=1e-9", "fluid.spacing=1e-7"})
              .find("the nozzle of emitter[0] takes about") != std::string::npos);
    CHECK(messages_with({"fluid.spacing=1e-8"}).find("particles need") != std::string::npos);
    // A wave maker is as large as the domain lets it be.
    CHECK(messages_with({"models.pressure=ppe", R"(solid[1]={shape="plane", normal=[1,0.5,0], position=["0.02*sin(6*t)-0.09",0,0]})"}) ==
          "no error");
    if (sizeof(Real) == 4)
        CHECK(messages_with({"domain.max=[300,0.1,0.1]", "emitter[0].position=[200,0.05,0]"})
                  .find("emitter[0] reaches 1e+05 spacings away from the origin, where this program's numbers tell places apart by 0.012 "
                        "spacings; move the scene to the origin, "
                        "or take the program of the preset \"double\"; allowed: up to 1.7e+02 m") != std::string::npos);
}

TEST_CASE("models that do not go together, or that this version does not have, are told", "[plan]") {
    CHECK(messages_with({"models.pressure=coupled", "models.viscosity=full"}) ==
          "--set models.viscosity=full: models.pressure = \"coupled\" solves for the viscosity itself; leave models.viscosity = \"full\" "
          "out, or choose "
          "another pressure; allowed: auto or none");
    CHECK(messages_with({"models.boundary=akinci"}).find("does not go with models.pressure = \"coupled\"") != std::string::npos);
    CHECK(messages_with({"models.viscosity=full_assembled", "models.pressure=ppe", "fluid.spacing=5e-4"}).find("would take") !=
          std::string::npos);
    CHECK(messages_with({"fluid.surface_tension=0.07", "models.pressure=none"}).find("keeps none apart") != std::string::npos);
    CHECK(messages_with({"boundary.gate=0.1", "models.pressure=coupled"})
              .find("boundary.gate belongs to solids of models.pressure = \"wcsph\" or \"ppe\", and this scene has models.pressure = "
                    "\"coupled\"") != std::string::npos);
    CHECK(messages_with({"boundary.volume_factor=1", "models.pressure=ppe"})
              .find("boundary.volume_factor belongs to solids of models.pressure = \"wcsph\"") != std::string::npos);
    CHECK(messages_with({"boundary.volume_factor=1", "models.pressure=wcsph"}) == "no error");
}

TEST_CASE("a force whose speeds the plan cannot know is warned of where sound has to be faster", "[plan]") {
    const auto warned = [](const std::vector<std::string>& changes) {
        const std::vector<std::string> all = plan_with(changes).warnings;
        return std::any_of(all.begin(), all.end(),
                           [](const std::string& w) { return w.find("without the speeds that fluid.force makes") != std::string::npos; });
    };
    CHECK(warned({"fluid.force=[1,0,0]", "models.pressure=wcsph"}));
    CHECK_FALSE(warned({"fluid.force=[1,0,0]", "models.pressure=wcsph", "pressure.sound_speed=20"}));
    CHECK_FALSE(warned({"fluid.force=[1,0,0]"}));
}

TEST_CASE("the plan of the assembled viscosity tells what its matrix takes", "[plan]") {
    const Plan plan = plan_with({"models.viscosity=full_assembled", "models.pressure=ppe"});
    // 251 lattice points nearer than four spacings, each nine numbers and an index.
    CHECK(choice(plan, "viscosity matrix").reason.find(sizeof(Real) == 4 ? "10.0 kB a particle" : "19.1 kB a particle") !=
          std::string::npos);
}

TEST_CASE("the monaghan Laplacian with few neighbours is warned of with its stiffness on a lattice", "[plan]") {
    const auto warning = [](const std::string& support) {
        std::string all;
        for (const std::string& w :
             plan_with({"models.viscosity=explicit", "viscosity.laplacian=monaghan", "models.pressure=ppe", "fluid.support=" + support})
                 .warnings)
            all += w;
        return all;
    };
    CHECK(warning("2").find("times as stiff") != std::string::npos);
    CHECK(warning("4").find("times as stiff") == std::string::npos);
}

TEST_CASE("all that is impossible is told in one go", "[plan]") {
    const std::string all = messages_with({"emitter[0].position=[0,0.2,0]", "boundary.gate=0.1", "fluid.spacing=0.02"});
    CHECK(std::count(all.begin(), all.end(), '\n') == 2);
}

namespace {

/// A periodic box of fluid with a micropolar model.
const std::string eddies = R"toml([time]
end = 1
[domain]
min = [0, 0, 0]
max = [1, 1, 1]
periodic = [true, true, true]
gravity = [0, 0, 0]
[fluid]
spacing = 0.05
viscosity = 4
[models]
micropolar = "seed"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [1, 1, 1]
velocity = ["sin(2*pi*x)", "0", "0"]
)toml";

std::string eddy_messages(const std::vector<std::string>& changes) {
    try {
        make_plan(scene_with(changes, eddies));
    } catch (const InputError& e) { return e.what(); }
    return "no error";
}

}  // namespace

TEST_CASE("the three micropolar systems differ in their viscosity and coupling, and long waves feel the one less half of the other",
          "[plan][micropolar]") {
    const auto numbers = [](const std::string& model) {
        return make_plan(
                   scene_with({"models.micropolar=" + model, "micropolar.transfer_viscosity=2", "micropolar.micro_inertia=0.01"}, eddies))
            .spin;
    };
    CHECK(numbers("seed").viscosity == Approx(4));
    CHECK(numbers("seed").coupling == Approx(6));
    CHECK(numbers("bender").viscosity == Approx(4));
    CHECK(numbers("bender").coupling == Approx(2));
    CHECK(numbers("eringen").viscosity == Approx(6));
    CHECK(numbers("eringen").coupling == Approx(2));
    CHECK(numbers("seed").effective_viscosity() == Approx(1));
    CHECK(numbers("seed").response_time() == Approx(0.01 * 1000 / 12));
    CHECK(numbers("seed").spin_viscosity == Approx(4 * 0.05 * 0.05));
    CHECK(numbers("seed").spin_length() == Approx(std::sqrt(4 * 0.01 / (6 * 2))));
}

TEST_CASE("a calibrated micropolar fluid has the effective viscosity and the spin length that were asked for, in every system",
          "[plan][micropolar]") {
    std::string text = eddies;
    text.replace(text.find("viscosity = 4\n"), 14, "");
    for (const std::string model : {"seed", "bender", "eringen"}) {
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

TEST_CASE("a micropolar system that feeds energy in is an error by default and a warning with its numbers where it was asked for",
          "[plan][micropolar]") {
    const std::string by_default = eddy_messages({"fluid.viscosity=0.001"});
    CHECK(by_default.find("models.micropolar = \"seed\" would feed energy in: its coupling, fluid.viscosity + the default "
                          "micropolar.transfer_viscosity = 0.3 Pa s, "
                          "is more than twice the 0.001 Pa s that models.viscosity = \"explicit\" applies") != std::string::npos);
    const Plan asked = make_plan(scene_with({"micropolar.transfer_viscosity=5", "micropolar.micro_inertia=0.01"}, eddies));
    REQUIRE(asked.warnings.size() == 1);
    CHECK(asked.warnings[0].find("coupling 9 Pa s is more than twice its viscosity 4 Pa s, so that slow flows feel -0.5 Pa s and waves "
                                 "longer than 0.419 m grow") != std::string::npos);
    CHECK(make_plan(scene_with({"models.micropolar=eringen", "micropolar.transfer_viscosity=500", "micropolar.micro_inertia=0.01"}, eddies))
              .warnings.empty());
    CHECK(make_plan(scene_with({}, eddies)).warnings[0].find("the spin answers to the flow in 233 s, longer than the run of 1 s") !=
          std::string::npos);
}

TEST_CASE("a transfer viscosity that the source of the seed system excludes is warned of", "[plan][micropolar]") {
    const auto warned = [](const std::vector<std::string>& changes) {
        const std::vector<std::string> all = make_plan(scene_with(changes, eddies)).warnings;
        return std::any_of(all.begin(), all.end(),
                           [](const std::string& w) { return w.find("the source of \"seed\" takes less than 0.4") != std::string::npos; });
    };
    CHECK(warned({"micropolar.transfer_viscosity=0.4"}));
    CHECK_FALSE(warned({"micropolar.transfer_viscosity=0.399"}));
    CHECK_FALSE(warned({"micropolar.transfer_viscosity=0.4", "models.micropolar=eringen"}));
}

TEST_CASE("micropolar keys that cannot be are told", "[plan][micropolar]") {
    CHECK(eddy_messages({"micropolar.micro_inertia=0"}).find("micropolar.micro_inertia") != std::string::npos);
    CHECK(eddy_messages({"micropolar.transfer_viscosity=-1"}).find("micropolar.transfer_viscosity") != std::string::npos);
    CHECK(eddy_messages({"fluid.viscosity=1+x"})
              .find("fluid.viscosity varies, and a micropolar model couples flow and spin by one viscosity") != std::string::npos);
    CHECK(eddy_messages({"micropolar.effective_viscosity=1"})
              .find("fluid.viscosity is chosen by micropolar.effective_viscosity; leave one of them out") != std::string::npos);
    CHECK(eddy_messages({"models.pressure=coupled"}).find("models.pressure = \"coupled\" has no micropolar terms") != std::string::npos);
    CHECK(eddy_messages({"models.micropolar=none", "viscosity.laplacian=split", "models.viscosity=explicit"})
              .find("splits by the coupling of a micropolar model") != std::string::npos);
    CHECK(eddy_messages({"viscosity.laplacian=split", "micropolar.transfer_viscosity=1"})
              .find("viscosity.laplacian = \"split\" leaves -1 Pa s for the form along the pairs (viscosity 4 less coupling 5), and that "
                    "feeds energy into compression") != std::string::npos);
    CHECK(eddy_messages({"viscosity.laplacian=split", "models.micropolar=eringen"}) == "no error");
    CHECK(eddy_messages({"models.micropolar=none", "block[0].spin=[0,0,1]"}).find("block[0].spin needs a micropolar model") !=
          std::string::npos);
}

TEST_CASE("the exchange is explicit where its stable step is long enough, else implicit", "[plan][micropolar]") {
    const auto scheme = [](const std::string& theta) {
        return choice(make_plan(scene_with({"micropolar.transfer_viscosity=2", "micropolar.micro_inertia=" + theta}, eddies)),
                      "micropolar.exchange")
            .value;
    };
    CHECK(scheme("0.1") == "explicit");
    CHECK(scheme("1e-6") == "implicit");
}

TEST_CASE("a background pressure is warned of where blocks leave room, not in a channel that is full but for its walls", "[plan]") {
    const auto channel = [](const std::string& top) {
        return make_plan(
            scene_with({},
                       "[time]\nend = 1\n[domain]\nmin = [0, -0.01, 0]\nmax = [0.2, 0.11, 0.1]\nperiodic = [true, false, true]\n"
                       "[fluid]\nspacing = 0.01\n[models]\npressure = \"wcsph\"\n[pressure]\nbackground_pressure = 100\n"
                       "[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.2, " +
                           top +
                           ", 0.1]\n"
                           "[[solid]]\nshape = \"box\"\nmin = [-0.1, -0.02, -0.1]\nmax = [0.3, 0, 0.2]\n"
                           "[[solid]]\nshape = \"box\"\nmin = [-0.1, 0.1, -0.1]\nmax = [0.3, 0.12, 0.2]\n"));
    };
    const auto warned = [](const Plan& plan) {
        return std::any_of(plan.warnings.begin(), plan.warnings.end(),
                           [](const std::string& w) { return w.find("background_pressure") != std::string::npos; });
    };
    CHECK_FALSE(warned(channel("0.1")));
    CHECK(warned(channel("0.05")));
}

TEST_CASE("keys of the published pressure rows are refused with other forms of pressure, and correction with source velocity",
          "[plan][pressure]") {
    const auto messages = [](const std::string& keys) -> std::string {
        try {
            make_plan(
                scene_with({},
                           "[time]\nend = 1\n[domain]\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\nperiodic = [true, true, true]\n[[block]]\n"
                           "shape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.05, 0.1]\n[fluid]\nspacing = 0.01\n[models]\n"
                           "pressure = \"ppe\"\n[pressure]\n" +
                               keys));
        } catch (const InputError& error) { return error.what(); }
        return "";
    };
    const std::string published = "form = \"projection\"\nsource = \"density\"\n", projection = "form = \"projection\"\n",
                      constraint = "form = \"constraint\"\n";
    for (const std::string key : {"clamp = false", "cycle = \"v_cycle\"", "sweeps = 2"}) {
        CHECK(messages(published + key).empty());
        CHECK(messages(projection + key).find("belongs to pressure.source = \"density\"") != std::string::npos);
        CHECK(messages(constraint + key).find("belongs to pressure.source = \"density\"") != std::string::npos);
    }
    CHECK(messages(published + "correction = 1").empty());
    CHECK(messages(published + "damping = 0").empty());
    CHECK(messages(projection + "damping = 0").find("pressure.source = \"velocity\" does not leave") != std::string::npos);
    CHECK(messages(constraint + "correction = 1").empty());
    CHECK(messages(projection + "correction = 1").find("pressure.source = \"velocity\" does not see") != std::string::npos);
    CHECK(messages(published + "sweeps = 0").find("at least 1") != std::string::npos);
    CHECK(messages(published + "cycle = \"w\"").find("additive or v_cycle") != std::string::npos);
}

TEST_CASE("keys that belong to another model than auto took, or that the chosen form leaves aside, are refused with their line",
          "[plan][pressure]") {
    const std::string start =
                          "[time]\nend = 1\n[domain]\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\nperiodic = [true, true, true]\n"
                          "[fluid]\nspacing = 0.01\nviscosity = 1e-3\n[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\n",
                      full = start + "max = [0.1, 0.1, 0.1]\n", half = start + "max = [0.1, 0.05, 0.1]\n";  // 13 lines
    const auto message = [](const std::string& text) -> std::string {
        try {
            make_plan(scene_with({}, text));
        } catch (const InputError& error) { return error.what(); }
        return "";
    };
    const auto refuses = [&](const std::string& text, const std::string& what, const std::string& way_out) {
        const std::string said = message(text);
        INFO(text << "\nsays: " << said);
        CHECK(said.find("honey.toml:15") != std::string::npos);
        CHECK(said.find(what) != std::string::npos);
        CHECK(said.find(way_out) != std::string::npos);
    };
    // A full box takes the projection by itself, one with a surface the constraint.
    refuses(full + "[pressure]\ndamping = 1\n", "pressure.damping is of motion between neighbours", "pressure.form = \"constraint\"");
    refuses(full + "[pressure]\ncorrection = 0.2\n", "pressure.correction is a share of the density error",
            "pressure.form = \"constraint\"");
    refuses(full + "[models]\nshifting = \"fickian\"\n", "evens out its particles itself", "pressure.form = \"constraint\"");
    refuses(half + "[pressure]\nsource = \"density\"\n",
            "pressure.source belongs to pressure.form = \"projection\", and \"auto\" takes \"constraint\" here", "or set pressure.form");
    refuses(half + "[pressure]\nsweeps = 2\nsource = \"density\"\n",
            "pressure.sweeps belongs to pressure.form = \"projection\", and \"auto\" takes \"constraint\" here", "or set pressure.form");
    for (const std::string key : {"sound_speed = 10", "gamma = 3", "gradient = \"difference\""})
        refuses(half + "[pressure]\n" + key + "\n", "belongs to models.pressure = \"wcsph\", and \"auto\" takes \"ppe\" here",
                "or set models.pressure");
    refuses(half + "[viscosity]\nalpha = 0.1\n", "belongs to models.viscosity = \"xsph\", and \"auto\" takes \"explicit\" here",
            "or set models.viscosity");
    // With source density the cycle is read where there is a multigrid.
    const std::string published = "[pressure]\ncycle = \"v_cycle\"\nform = \"projection\"\nsource = \"density\"\n";
    refuses(half + published + "preconditioner = \"jacobi\"\n", "pressure.cycle is of the multigrid", "\"multigrid\"");
    CHECK(message(half + published + "preconditioner = \"multigrid\"\n").empty());
    CHECK(message(half + published).empty());
    // Nothing damps the published rows in a full box without weight.
    CHECK(message(full + "[models]\npressure = \"ppe\"\n[pressure]\nform = \"projection\"\nsource = \"density\"\n")
              .find("gains energy in fluid that fills its space and rests on nothing") != std::string::npos);
    // What is read passes, and so do defaults: a resolved scene writes them.
    CHECK(message(half + "[pressure]\ndamping = 1\ncorrection = 0.2\n").empty());
    CHECK(message(half + published + "damping = 1\ncorrection = 0.2\n").empty());
    CHECK(message(half + "[models]\nshifting = \"fickian\"\n").empty());
    CHECK(message(full + "[pressure]\ndamping = 2\ngamma = 7\n").empty());
    CHECK(message(resolved_toml(scene_with({}, full))).empty());
}

TEST_CASE("the projection is refused where fluid splashes, and taken by itself where fluid fills its space", "[plan][pressure]") {
    const std::string start = "[time]\nend = 1\n[domain]\nmin = [-0.1, -0.1, -0.1]\nmax = [1, 1, 0.3]\n[fluid]\nspacing = 0.01\n",
                      projection = "[models]\npressure = \"ppe\"\n[pressure]\nform = \"projection\"\n",
                      tank = "[[solid]]\nshape = \"box\"\ninside = true\nmin = [0, 0, 0]\nmax = [0.4, 0.4, 0.2]\n";
    const auto block = [](const char* max) { return std::string("[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = ") + max + "\n"; };
    const auto message = [&](const std::string& text) -> std::string {
        try {
            make_plan(scene_with({}, start + text));
        } catch (const InputError& error) { return error.what(); }
        return "";
    };
    CHECK(message(projection + tank + block("[0.4, 0.2, 0.2]")).empty());
    CHECK(message(projection + tank + block("[0.2, 0.2, 0.2]")).find("nothing holds") != std::string::npos);
    CHECK(message(projection + tank + "[[emitter]]\nposition = [0.2, 0.3, 0.1]\nradius = 0.03\nspeed = 0.5\n")
              .find("emitter[0] pours onto something") != std::string::npos);
    CHECK(message(projection + tank + block("[0.4, 0.4, 0.2]") +
                  "[[solid]]\nshape = \"sphere\"\nradius = 0.05\nposition = [0.2, 0.2, 0.1]\ndensity = 900\n")
              .empty());
    CHECK(message("surface_tension = 0.1\n" + projection + tank + block("[0.4, 0.2, 0.2]")).empty());
    CHECK(message("surface_tension = 0.1\n" + projection + tank + "wetting = 0.75\n" + block("[0.4, 0.2, 0.2]"))
              .find("a surface stands at 90 degrees on solids") != std::string::npos);
    const auto form = [&](const std::string& text) { return make_plan(scene_with({}, start + text)).facts.pressure.form; };
    CHECK(form(tank + block("[0.4, 0.4, 0.2]")) == PressureForm::projection);
    CHECK(form(tank + block("[0.4, 0.2, 0.2]")) == PressureForm::constraint);
}

TEST_CASE("without weight the projection is refused but for a single body that its rotation does not tear", "[plan][pressure]") {
    const auto message = [&](const std::string& text) -> std::string {
        try {
            make_plan(scene_with({},
                                 "[time]\nend = 0.5\n[domain]\nmin = [-0.1, -0.1, -0.1]\nmax = [0.1, 0.1, 0.1]\ngravity = [0, 0, 0]\n"
                                 "[models]\npressure = \"ppe\"\n[pressure]\nform = \"projection\"\n" +
                                     text));
        } catch (const InputError& error) { return error.what(); }
        return "";
    };
    const std::string still = "[[block]]\nshape = \"sphere\"\nradius = 0.03\n", turns = still + "velocity = [\"-9*y\", \"9*x\", \"0\"]\n",
                      squeezed = still + "velocity = [\"-9*x\", \"9*y\", \"0\"]\n", thin = "[fluid]\nspacing = 0.004\n",
                      thick = thin + "viscosity = 700\n";
    CHECK(message(thin + still).empty());
    CHECK(message(thin + squeezed).empty());
    CHECK(message(thick + turns).empty());
    CHECK(message(thin + "surface_tension = 3\n" + turns).empty());
    CHECK(message(thin + turns).find("this one turns at 9 /s and pulls at its own surface") != std::string::npos);
    CHECK(message(thin + still + "[[block]]\nshape = \"sphere\"\nradius = 0.01\nposition = [0.06, 0, 0]\n").find("they may meet") !=
          std::string::npos);
    CHECK(message(thin + still + "[[solid]]\nshape = \"plane\"\nposition = [0, -0.06, 0]\n").find("this scene has a solid") !=
          std::string::npos);
    CHECK(message(thin + still + "[[emitter]]\nposition = [0.05, 0, 0]\nradius = 0.01\nspeed = 0.1\n").find("has an emitter") !=
          std::string::npos);
}

TEST_CASE("in two dimensions the plan counts particles by area, and refuses by name what the plane does not have", "[plan][plane]") {
    const std::string tank = R"toml([time]
end = 1
[domain]
dimensions = 2
min = [-0.1, -0.1]
max = [0.3, 0.3]
[fluid]
spacing = 0.01
viscosity = 100
[[block]]
shape = "box"
min = [0, 0]
max = [0.2, 0.1]
[[solid]]
shape = "box"
min = [0, 0]
max = [0.2, 0.2]
inside = true
)toml";
    const Plan plan = make_plan(scene_with({}, tank));
    CHECK(plan.estimated_particles == Approx(200));
    CHECK(plan.particle_volume() == Approx(1e-4));
    CHECK(plan.pressure == PressureModel::ppe);  // coupled, which so thick a fluid would have in space, is none for the plane
    CHECK(plan.kernel.dimensions == 2);
    CHECK(plan.support == Approx(0.02));

    const auto messages = [&](const std::string& change) {
        try {
            make_plan(scene_with({change}, tank));
        } catch (const InputError& e) { return std::string(e.what()); }
        return std::string("no error");
    };
    const std::string here = " in two dimensions (domain.dimensions = 2)";
    CHECK(messages("models.pressure=coupled").find("models.pressure = \"coupled\" does not work" + here) != std::string::npos);
    CHECK(messages("fluid.surface_tension=0.07").find("particles that pull at each other make no surface tension" + here) !=
          std::string::npos);
    CHECK(messages("output.export=[\"vdb\"]").find("there is no surface to export as \"vdb\"" + here) != std::string::npos);
}

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "engine/scene/checks.h"
#include "tests/support/poured_honey.h"
#include "tests/support/scratch.h"

using namespace whorl;
using test::messages_with;
using test::plan_with;

TEST_CASE("a size in a wrong unit is reported with key, meaning and likely mistake", "[plan]") {
    const auto warned = [](const std::vector<std::string>& changes, const std::string& text) {
        const std::vector<std::string> all = plan_with(changes).warnings;
        INFO(text);
        for (const std::string& w : all) UNSCOPED_INFO(w);
        return std::find(all.begin(), all.end(), text) != all.end();
    };
    const std::vector<std::string> large{"domain.max=[120,240,120]", "domain.min=[-120,0,-120]", "fluid.spacing=0.5", "emitter[0].radius=5",
                                         "emitter[0].position=[0,100,0]"};
    CHECK(warned(large, "domain.max: the domain is 240 m long; lengths are in metres"));
    CHECK(warned(large, "emitter[0].radius: the nozzle is 10 m across; lengths are in metres"));
    const std::string fast = "emitter[0].speed: the fluid moves at 300 m/s; speeds are in m/s";
    CHECK(warned({"emitter[0].speed=300", "time.end=0.01"}, fast));
    CHECK(warned({"emitter[0].speed=300*min(1,1000*t)", "time.end=0.01"}, fast));
    CHECK(messages_with({"emitter[0].speed=1/t"}) == "--set emitter[0].speed=1/t: emitter[0].speed is inf m/s at t = 0 s");
    const std::string gas = "fluid.density = 1: liquids have 100 to 25000 kg/m^3 (water 1000, air 1.2)";
    CHECK(warned({"fluid.density=1.3"}, "fluid.density = 1.3: liquids have 100 to 25000 kg/m^3 (water 1000, air 1.2)"));
    CHECK(warned({"fluid.density=1"}, gas));
    CHECK(!warned({"fluid.density=1", "domain.gravity=[0,0,0]"}, gas));   // has no units
    CHECK(!warned({"fluid.density=1", "domain.gravity=[0,-1,0]"}, gas));  // also without units
    CHECK(warned({"fluid.surface_tension=72"}, "fluid.surface_tension = 72: liquids have up to 4 N/m (water 0.072)"));
    CHECK(warned({"domain.gravity=[0,-9810,0]"}, "domain.gravity = 9810 is 1e+03 times the earth's; it is in m/s^2"));
    CHECK_THAT(messages_with({"emitter[0].radius=5"}),
               Catch::Contains("the opening of emitter[0] is 10 m across, wider than the whole domain (0.2 m)") &&
                   Catch::Contains("a likely slip: emitter[0].radius: the nozzle is 10 m across; lengths are in metres"));
    // A whole run of it would have more particles than fit into any memory.
    CHECK_THAT(messages_with({"emitter[0].speed=300", "time.end=1000", "fluid.spacing=0.001"}),
               Catch::Contains("most of them are from emitter[0], which emits ") && Catch::Contains("a likely slip: " + fast));
}

TEST_CASE("a solid that is a thousand times too large is reported with its key", "[plan]") {
    const auto warnings = [](const std::string& shape) { return plan_with({"solid[0]={" + shape + "}"}).warnings; };
    const std::string plate = "shape=\"cylinder\", from=[0,-0.004,0], to=[0,0,0], radius=";
    CHECK(warnings(plate + "0.06").empty());
    CHECK(warnings(plate + "2").empty());  // a table
    CHECK(warnings(plate + "60") ==
          std::vector<std::string>{"solid[0].radius: the cylinder is 120 m across in a domain of 0.2 m; lengths are in metres"});
    CHECK(warnings("shape=\"box\", min=[-60,-4,-60], max=[60,0,60]") ==
          std::vector<std::string>{"solid[0].max: the box is 120 m across in a domain of 0.2 m; lengths are in metres"});
    CHECK(warnings("shape=\"cylinder\", from=[0,-80,0], to=[0,0,0], radius=0.05").size() == 1);
    CHECK(warnings("shape=\"plane\"").empty());
}

TEST_CASE("a solid larger than the domain is reported with the emitter inside it", "[plan]") {
    const std::string said = messages_with({"solid[0]={shape=\"sphere\", radius=5000}"});
    CHECK_THAT(said, Catch::Contains("emitter[0] at (0, 0.08, 0) lies 5e+03 m inside solid[0]") &&
                         Catch::Contains("solid[0].radius: the sphere is 1e+04 m across in a domain of 0.2 m; lengths are in metres"));
    CHECK(said.find("fluid.spacing") == std::string::npos);
}

TEST_CASE("a light body may be hollow, or given in g/cm^3", "[plan]") {
    const std::vector<std::string> all =
        plan_with({"solid[1]={shape=\"sphere\", radius=0.02, position=[0.06,0.04,0.06], density=3}"}).warnings;
    REQUIRE(all.size() == 1);
    CHECK(all[0] == "solid[1].density = 3: solids have 10 to 25000 kg/m^3 (cork 200, steel 7800)");
}

TEST_CASE("bodies in honey get the coupled pressure, and the constraint is warned of", "[plan]") {
    const std::string body = "solid[1]={shape=\"sphere\", radius=0.02, position=[0.06,0.04,0.06], density=2000}";
    const Plan automatic = plan_with({body});
    CHECK(automatic.pressure == PressureModel::coupled);
    CHECK(automatic.warnings.empty());
    const std::vector<std::string> all = plan_with({body, "models.pressure=ppe"}).warnings;
    REQUIRE(all.size() == 1);
    CHECK_THAT(all[0], Catch::Contains("holds back bodies in viscous fluid") && Catch::Contains("\"coupled\" moves them right"));
}

TEST_CASE("a wrong unit is reported next to the mistake that it causes", "[plan]") {
    CHECK_THAT(messages_with({"emitter[0].speed=300", "time.end=0.01", "models.pressure=coupled", "fluid.viscosity=1"}),
               Catch::Contains("too thin for models.pressure = \"coupled\"") &&
                   Catch::Contains("--set emitter[0].speed=300: a likely slip: emitter[0].speed: the fluid moves at 300 m/s"));
}

TEST_CASE("a mesh that is a thousand times too large or too small is reported", "[plan]") {
    const test::ScratchFolder folder;
    std::ofstream(folder / "bowl.obj") << "v 0 0 0\nv 30 0 0\nv 0 30 0\nv 0 0 30\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    const auto warnings = [&](const std::string& scale) {
        return plan_with({"solid[0]={shape=\"mesh\", file=\"" + (folder / "bowl.obj").string() +
                          "\", position=[0.02, -0.008, 0.02], scale=" + scale + "}"})
            .warnings;
    };
    CHECK(warnings("1e-3").empty());
    REQUIRE(warnings("1").size() == 1);
    CHECK(warnings("1")[0] == "solid[0].scale: the mesh is 30 m across in a domain of 0.2 m; a mesh in millimetres needs scale = 1e-3");
    REQUIRE(warnings("1e-6").size() == 1);
    CHECK(warnings("1e-6")[0].find("less than two particles of 0.002 m") != std::string::npos);
    std::ofstream(folder / "bowl.obj", std::ios::app) << "f 1 3 2\n";
    REQUIRE(warnings("1e-3").size() == 1);
    CHECK(warnings("1e-3")[0] == "solid[0].file: faces that repeat others left out: 1");
}

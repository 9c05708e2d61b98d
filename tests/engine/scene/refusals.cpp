#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/scene/plan.h"
#include "engine/scene/read.h"
#include "tests/support/poured_honey.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using test::messages_with;
using test::scene_with;

TEST_CASE("impossible scenes are refused with location and hint", "[plan]") {
    const std::string domain = "; the domain goes from (-0.1, -0.01, -0.1) to (0.1, 0.1, 0.1)";
    CHECK(messages_with({"emitter[0].position=[0,0.2,0]"}) ==
          "--set emitter[0].position=[0,0.2,0]: emitter[0] at (0, 0.2, 0) lies outside of the domain" + domain);
    CHECK(messages_with({"emitter[0].position=[0,-0.005,0]"}) ==
          "--set emitter[0].position=[0,-0.005,0]: emitter[0] at (0, -0.005, 0) lies 0.005 m inside solid[0]; move one of them");
    CHECK(messages_with({"fluid.spacing=0.02"}) ==
          "--set fluid.spacing=0.02: fluid.spacing = 0.02 m is larger than emitter[0], which is 0.01 m across; 0.002 m puts 5 particles "
          "across it");
    CHECK(messages_with({"emitter[0].speed=0.1-t"}).find("emitter[0].speed is -0.0") != std::string::npos);
    const std::string stream = "min=[0,0,0], max=[0.1,0.1,0.1]}";
    for (const auto& [set, expected] : std::vector<std::pair<std::string, std::string>>{
             {"fluid.force=[0, 0, \"1/(2-t)^0.5\"]", "fluid.force is not finite at t = 2 s"},
             {"solid[0].position=[0, \"0.01*(1-t)^0.5\", 0]", "solid[0].position is not finite at t = 1.016 s"},
             {"solid[0].rotation=[0, \"(1-t)^0.5\", 0]", "solid[0].rotation is not finite at t = 1.016 s"},
             {"emitter[0].position=[\"0.05*t\", 0.05, 0]",
              "emitter[0] is outside of the domain at t = 2.016 s, at (0.1008, 0.05, 0)" + domain},
             {"emitter[0].position=[0, \"0.05*(1-t)^0.5\", 0]", "emitter[0] is not finite at t = 1.016 s"},
             {"emitter[0].direction=[0, \"t < 1 ? -1 : 0\", 0]", "emitter[0].direction has no length at t = 1 s"}})
        CHECK_THAT(messages_with({"time.end=4", set}), Catch::Contains("--set " + set + ": " + expected));
    CHECK_THAT(messages_with({"block[0]={shape=\"box\", min=[0,0.02,0], max=[0.05,0.06,0.05]}", "emitter[0].viscosity=1000",
                              "models.pressure=ppe", "fluid.viscosity=3000-1000*age"}),
               Catch::Contains("block[0] at the age of 3.016 s; allowed: at least 0"));
    CHECK(messages_with({"emitter[0].start=3", "emitter[0].viscosity=1100-1000*age"}) == "no error");
    for (const auto& [changes, part] : std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"emitter[0].start=3", "emitter[0].viscosity=900-1000*age"}, "at the age of 0.9"},
             {{"stream[0]={velocity=[\"(0-t)^0.5\", 0, 0], time=1, " + stream}, "stream[0].velocity is not finite at t = "},
             {{"time.end=4", "models.micropolar=bender", "micropolar.torque=[0, \"log(1-t)\", 0]"},
              "micropolar.torque is not finite at t = 1 s"},
             {{"block[0]={shape=\"box\", min=[0.2,0,0], max=[0.3,0.1,0.1]}"}, "block[0] lies outside of the domain"},
             {{"block[0]={shape=\"box\", min=[0.05,0,0], max=[0.15,0.1,0.1]}"}, "block[0] reaches out of the domain"},
             {{"solid[1]={shape=\"sphere\", radius=0.01, density=900, pivot=[0,0,0]}"}, "solid[1] has a density, so it turns about its"},
             {{"solid[1]={shape=\"sphere\", radius=0.01, position=[1,0,0]}"}, "solid[1] lies outside of the domain and never enters it"},
             {{"probe[0]={name=\"a\", kind=\"point\", at=[0,9,0]}"}, "probe[0] measures outside the domain"},
             {{"domain.periodic=[true,false,false]", "domain.min=[-0.004,-0.01,-0.1]", "domain.max=[0.004,0.1,0.1]"},
              "the periodic axis x is 0.008 m long, shorter than two support radii of 0.008 m"},
             {{"models.pressure=ppe", "fluid.support=1.2", "domain.periodic=[true,false,false]", "domain.min=[-0.003,-0.01,-0.1]",
               "domain.max=[0.003,0.1,0.1]"},
              "the periodic axis x is 0.006 m long, shorter than two support radii of 0.004 m"},
             {{"block[0]={shape=\"cylinder\", from=[-0.09,0,-0.09], to=[0.09,0.09,0.09], radius=1e-5}", "fluid.spacing=1e-5"},
              "block[0] fills "},
             {{"models.pressure=ppe", "solid[1]={shape=\"sphere\", radius=1000, container=true}"},
              "the surface of solid[1] needs about 3.1e+12"}}) {
        CAPTURE(changes);
        CHECK_THAT(messages_with(changes), Catch::Contains(part));
    }
    for (const auto& [y, hint] : {std::pair("0", "make the domain smaller or"), {"\"0.01*t\"", "make it move less or"}})
        CHECK_THAT(messages_with({"models.pressure=ppe", "domain.min=[-1000,-0.01,-1000]", "domain.max=[1000,0.1,1000]",
                                  "solid[0].position=[0," + std::string(y) + ",0]"}),
                   Catch::Contains(hint));
    CHECK_THAT(messages_with({"emitter[0].radius=0.09", "emitter[0].speed=1e-9", "fluid.spacing=1e-7"}),
               Catch::Contains("the nozzle of emitter[0] needs about"));
    CHECK(messages_with({"fluid.spacing=1e-8"}).find("particles need") != std::string::npos);
    // The domain limits the size of a wave maker.
    CHECK(messages_with({"models.pressure=ppe", R"(solid[1]={shape="plane", normal=[1,0.5,0], position=["0.02*sin(6*t)-0.09",0,0]})"}) ==
          "no error");
    if (sizeof(Real) == 4)
        CHECK_THAT(messages_with({"domain.max=[300,0.1,0.1]", "emitter[0].position=[200,0.05,0]"}),
                   Catch::Contains("emitter[0] reaches 1e+05 spacings away from the origin, where positions are resolved to 0.012 "
                                   "spacings; move the scene to the origin, "
                                   "or use a build with the preset \"double\"; allowed: up to 1.7e+02 m"));
}

TEST_CASE("incompatible or missing models are refused", "[plan]") {
    CHECK(messages_with({"models.pressure=coupled", "models.viscosity=full"}) ==
          "--set models.viscosity=full: models.pressure = \"coupled\" solves for the viscosity itself; leave models.viscosity = \"full\" "
          "out, or choose "
          "another pressure; allowed: auto or none");
    for (const auto& [changes, part] : std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"models.boundary=akinci"}, "does not go with models.pressure = \"coupled\""},
             {{"models.viscosity=full_assembled", "models.pressure=ppe", "fluid.spacing=5e-4"}, "would need"},
             {{"fluid.surface_tension=0.07", "models.pressure=none"}, "keeps none apart"},
             {{"boundary.gate=0.1", "models.pressure=coupled"},
              "boundary.gate belongs to models.boundary = \"akinci\" or \"ppe\", and \"auto\" takes \"none\" here"},
             {{"boundary.volume_factor=1", "models.pressure=ppe"},
              "boundary.volume_factor belongs to models.boundary = \"akinci\", and \"auto\" takes \"ppe\" here"}}) {
        CAPTURE(changes);
        CHECK_THAT(messages_with(changes), Catch::Contains(part));
    }
    CHECK(messages_with({"boundary.volume_factor=1", "models.pressure=wcsph"}) == "no error");
}

TEST_CASE("all impossible keys are reported together", "[plan]") {
    const std::string all = messages_with({"emitter[0].position=[0,0.2,0]", "boundary.gate=0.1", "fluid.spacing=0.02"});
    CHECK(std::count(all.begin(), all.end(), '\n') == 2);
}

TEST_CASE("keys of the published pressure rows are refused with other forms, correction with velocity source", "[plan][pressure]") {
    const auto messages = [](const std::string& keys) {
        return messages_with({}, test::text::time(1) + test::text::domain({0, 0, 0}, {0.1, 0.1, 0.1}, "periodic = [true, true, true]") +
                                     test::text::block({0, 0, 0}, {0.1, 0.05, 0.1}) + test::text::fluid(0.01) + test::text::models("ppe") +
                                     "[pressure]\n" + keys);
    };
    const std::string published = "form = \"projection\"\nsource = \"density\"\n", projection = "form = \"projection\"\n",
                      constraint = "form = \"constraint\"\n";
    for (const std::string key : {"clamp = false", "cycle = \"v_cycle\"", "sweeps = 2"}) {
        CHECK(messages(published + key) == "no error");
        CHECK(messages(projection + key).find("belongs to pressure.source = \"density\"") != std::string::npos);
        CHECK(messages(constraint + key).find("belongs to pressure.source = \"density\"") != std::string::npos);
    }
    CHECK(messages(published + "correction = 1") == "no error");
    CHECK(messages(published + "damping = 0") == "no error");
    CHECK(messages(projection + "damping = 0").find("pressure.source = \"velocity\" already removes") != std::string::npos);
    CHECK(messages(constraint + "correction = 1") == "no error");
    CHECK(messages(projection + "correction = 1").find("pressure.source = \"velocity\" does not correct") != std::string::npos);
    CHECK(messages(published + "sweeps = 0").find("at least 1") != std::string::npos);
    CHECK(messages(published + "cycle = \"w\"").find("additive or v_cycle") != std::string::npos);
}

TEST_CASE("keys that the chosen models or forms do not use are refused with their line", "[plan][pressure]") {
    const std::string start = test::text::time(1) + test::text::domain({0, 0, 0}, {0.1, 0.1, 0.1}, "periodic = [true, true, true]") +
                              test::text::fluid(0.01, 1e-3),
                      full = start + test::text::block({0, 0, 0}, {0.1, 0.1, 0.1}),
                      half = start + test::text::block({0, 0, 0}, {0.1, 0.05, 0.1});  // 14 lines
    const auto message = [](const std::string& text) { return messages_with({}, text); };
    const auto refuses = [&](const std::string& text, const std::string& what, const std::string& way_out) {
        const std::string said = message(text);
        INFO(text << "\nsays: " << said);
        CHECK(said.find("honey.toml:16") != std::string::npos);
        CHECK(said.find(what) != std::string::npos);
        CHECK(said.find(way_out) != std::string::npos);
    };
    // The plan chooses the projection for a full box, the constraint for one with a surface.
    refuses(full + "[pressure]\ndamping = 1\n", "pressure.damping acts on motion between neighbours", "pressure.form = \"constraint\"");
    refuses(full + "[pressure]\ncorrection = 0.2\n", "pressure.correction is a share of the density error",
            "pressure.form = \"constraint\"");
    refuses(full + "[models]\nshifting = \"fickian\"\n", "spreads its particles evenly itself", "pressure.form = \"constraint\"");
    refuses(half + "[pressure]\nsource = \"density\"\n",
            "pressure.source belongs to pressure.form = \"projection\", and \"auto\" takes \"constraint\" here", "or set pressure.form");
    refuses(half + "[pressure]\nsweeps = 2\nsource = \"density\"\n",
            "pressure.sweeps belongs to pressure.form = \"projection\", and \"auto\" takes \"constraint\" here", "or set pressure.form");
    for (const std::string key : {"sound_speed = 10", "gamma = 3", "gradient = \"difference\""})
        refuses(half + "[pressure]\n" + key + "\n", "belongs to models.pressure = \"wcsph\", and \"auto\" takes \"ppe\" here",
                "or set models.pressure");
    refuses(half + "[viscosity]\nalpha = 0.1\n", "belongs to models.viscosity = \"xsph\", and \"auto\" takes \"explicit\" here",
            "or set models.viscosity");
    // With source density the cycle is used if there is a multigrid.
    const std::string published = "[pressure]\ncycle = \"v_cycle\"\nform = \"projection\"\nsource = \"density\"\n";
    refuses(half + published + "preconditioner = \"jacobi\"\n", "pressure.cycle is an option of the multigrid", "\"multigrid\"");
    CHECK(message(half + published + "preconditioner = \"multigrid\"\n") == "no error");
    CHECK(make_plan(scene_with({}, half + published)).preconditioner == Preconditioner::multigrid);
    // The published rows have no damping in a full box without weight.
    CHECK_THAT(message(full + "[models]\npressure = \"ppe\"\n[pressure]\nform = \"projection\"\nsource = \"density\"\n"),
               Catch::Contains("gains energy in confined fluid without gravity"));
    // Used keys pass, and so do defaults: a resolved scene writes them.
    CHECK(message(half + "[pressure]\ndamping = 1\ncorrection = 0.2\n") == "no error");
    CHECK(message(half + published + "damping = 1\ncorrection = 0.2\n") == "no error");
    CHECK(message(half + "[models]\nshifting = \"fickian\"\n") == "no error");
    CHECK(message(full + "[pressure]\ndamping = 2\ngamma = 7\n") == "no error");
    CHECK(message(resolved_toml(scene_with({}, full))) == "no error");
}

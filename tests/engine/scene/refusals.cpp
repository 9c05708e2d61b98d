#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/scene/plan.h"
#include "engine/scene/read.h"
#include "tests/support/poured_honey.h"

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
             {"solid[0].rotation=[0, \"(1-t)^0.5\", 0]", "solid[0].rotation is not finite at t = 1.016 s"}})
        CHECK_THAT(messages_with({"time.end=4", set}), Catch::Contains("--set " + set + ": " + expected));
    CHECK_THAT(messages_with({"block[0]={shape=\"box\", min=[0,0.02,0], max=[0.05,0.06,0.05]}", "emitter[0].viscosity=1000",
                              "models.pressure=ppe", "fluid.viscosity=3000-1000*age"}),
               Catch::Contains("block[0] at the age of 3.016 s; allowed: at least 0"));
    CHECK(messages_with({"emitter[0].start=3", "emitter[0].viscosity=1100-1000*age"}) == "no error");
    CHECK_THAT(messages_with({"emitter[0].start=3", "emitter[0].viscosity=900-1000*age"}), Catch::Contains("at the age of 0.9"));
    CHECK_THAT(messages_with({"stream[0]={velocity=[\"(0-t)^0.5\", 0, 0], time=1, " + stream}),
               Catch::Contains("stream[0].velocity is not finite at t = "));
    CHECK_THAT(messages_with({"time.end=4", "models.micropolar=bender", "micropolar.torque=[0, \"log(1-t)\", 0]"}),
               Catch::Contains("micropolar.torque is not finite at t = 1 s"));
    CHECK(messages_with({"block[0]={shape=\"box\", min=[0.2,0,0], max=[0.3,0.1,0.1]}"}).find("block[0] lies outside of the domain") !=
          std::string::npos);
    CHECK(messages_with({"block[0]={shape=\"box\", min=[0.05,0,0], max=[0.15,0.1,0.1]}"}).find("block[0] reaches out of the domain") !=
          std::string::npos);
    CHECK(messages_with({"solid[1]={shape=\"sphere\", radius=0.01, position=[1,0,0]}"})
              .find("solid[1] lies outside of the domain and never enters it") != std::string::npos);
    CHECK(messages_with({"probe[0]={name=\"a\", kind=\"point\", at=[0,9,0]}"}).find("probe[0] measures outside the domain") !=
          std::string::npos);
    CHECK(messages_with({"domain.periodic=[true,false,false]", "domain.min=[-0.004,-0.01,-0.1]", "domain.max=[0.004,0.1,0.1]"})
              .find("the periodic axis x is 0.008 m long, shorter than two support radii of 0.008 m") != std::string::npos);
    CHECK(messages_with({"models.pressure=ppe", "fluid.support=1.2", "domain.periodic=[true,false,false]", "domain.min=[-0.003,-0.01,-0.1]",
                         "domain.max=[0.003,0.1,0.1]"})
              .find("the periodic axis x is 0.006 m long, shorter than two support radii of 0.004 m") != std::string::npos);
    CHECK(messages_with({"block[0]={shape=\"cylinder\", from=[-0.09,0,-0.09], to=[0.09,0.09,0.09], radius=1e-5}", "fluid.spacing=1e-5"})
              .find("block[0] fills ") != std::string::npos);
    CHECK(messages_with({"models.pressure=ppe", "solid[1]={shape=\"sphere\", radius=1000, container=true}"})
              .find("the surface of solid[1] needs about 3.1e+12") != std::string::npos);
    for (const auto& [y, hint] : {std::pair("0", "make the domain smaller or"), {"\"0.01*t\"", "make it move less or"}})
        CHECK_THAT(messages_with({"models.pressure=ppe", "domain.min=[-1000,-0.01,-1000]", "domain.max=[1000,0.1,1000]",
                                  "solid[0].position=[0," + std::string(y) + ",0]"}),
                   Catch::Contains(hint));
    CHECK(messages_with({"emitter[0].radius=0.09", "emitter[0].speed=1e-9", "fluid.spacing=1e-7"})
              .find("the nozzle of emitter[0] needs about") != std::string::npos);
    CHECK(messages_with({"fluid.spacing=1e-8"}).find("particles need") != std::string::npos);
    // The domain limits the size of a wave maker.
    CHECK(messages_with({"models.pressure=ppe", R"(solid[1]={shape="plane", normal=[1,0.5,0], position=["0.02*sin(6*t)-0.09",0,0]})"}) ==
          "no error");
    if (sizeof(Real) == 4)
        CHECK(messages_with({"domain.max=[300,0.1,0.1]", "emitter[0].position=[200,0.05,0]"})
                  .find("emitter[0] reaches 1e+05 spacings away from the origin, where positions are resolved to 0.012 "
                        "spacings; move the scene to the origin, "
                        "or use a build with the preset \"double\"; allowed: up to 1.7e+02 m") != std::string::npos);
}

TEST_CASE("incompatible or missing models are refused", "[plan]") {
    CHECK(messages_with({"models.pressure=coupled", "models.viscosity=full"}) ==
          "--set models.viscosity=full: models.pressure = \"coupled\" solves for the viscosity itself; leave models.viscosity = \"full\" "
          "out, or choose "
          "another pressure; allowed: auto or none");
    CHECK(messages_with({"models.boundary=akinci"}).find("does not go with models.pressure = \"coupled\"") != std::string::npos);
    CHECK(messages_with({"models.viscosity=full_assembled", "models.pressure=ppe", "fluid.spacing=5e-4"}).find("would need") !=
          std::string::npos);
    CHECK(messages_with({"fluid.surface_tension=0.07", "models.pressure=none"}).find("keeps none apart") != std::string::npos);
    CHECK(messages_with({"boundary.gate=0.1", "models.pressure=coupled"})
              .find("boundary.gate belongs to models.boundary = \"akinci\" or \"ppe\", and \"auto\" takes \"none\" here") !=
          std::string::npos);
    CHECK(messages_with({"boundary.volume_factor=1", "models.pressure=ppe"})
              .find("boundary.volume_factor belongs to models.boundary = \"akinci\", and \"auto\" takes \"ppe\" here") !=
          std::string::npos);
    CHECK(messages_with({"boundary.volume_factor=1", "models.pressure=wcsph"}) == "no error");
}

TEST_CASE("all impossible keys are reported together", "[plan]") {
    const std::string all = messages_with({"emitter[0].position=[0,0.2,0]", "boundary.gate=0.1", "fluid.spacing=0.02"});
    CHECK(std::count(all.begin(), all.end(), '\n') == 2);
}

TEST_CASE("keys of the published pressure rows are refused with other forms, correction with velocity source", "[plan][pressure]") {
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
    CHECK(messages(projection + "damping = 0").find("pressure.source = \"velocity\" already removes") != std::string::npos);
    CHECK(messages(constraint + "correction = 1").empty());
    CHECK(messages(projection + "correction = 1").find("pressure.source = \"velocity\" does not correct") != std::string::npos);
    CHECK(messages(published + "sweeps = 0").find("at least 1") != std::string::npos);
    CHECK(messages(published + "cycle = \"w\"").find("additive or v_cycle") != std::string::npos);
}

TEST_CASE("keys that the chosen models or forms do not use are refused with their line", "[plan][pressure]") {
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
    CHECK(message(half + published + "preconditioner = \"multigrid\"\n").empty());
    CHECK(make_plan(scene_with({}, half + published)).preconditioner == Preconditioner::multigrid);
    // The published rows have no damping in a full box without weight.
    CHECK(message(full + "[models]\npressure = \"ppe\"\n[pressure]\nform = \"projection\"\nsource = \"density\"\n")
              .find("gains energy in confined fluid without gravity") != std::string::npos);
    // Used keys pass, and so do defaults: a resolved scene writes them.
    CHECK(message(half + "[pressure]\ndamping = 1\ncorrection = 0.2\n").empty());
    CHECK(message(half + published + "damping = 1\ncorrection = 0.2\n").empty());
    CHECK(message(half + "[models]\nshifting = \"fickian\"\n").empty());
    CHECK(message(full + "[pressure]\ndamping = 2\ngamma = 7\n").empty());
    CHECK(message(resolved_toml(scene_with({}, full))).empty());
}

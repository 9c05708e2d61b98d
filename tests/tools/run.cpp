#include "tools/film/run.h"

#include <signal.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/io/csv.h"
#include "engine/scene/plan.h"
#include "render/image/image.h"
#include "tests/support/film_runs.h"
#include "tests/support/program.h"
#include "tests/support/scene_text.h"
#include "tests/support/scenes.h"
#include "tools/film/report.h"

using namespace whorl;
using test::Outcome;
using test::Program;
namespace fs = std::filesystem;

namespace run_test {

using test::files_in;
using test::honey;
using test::lines;
using test::report;
using test::reproducible;
using Scratch = test::FilmScratch;

namespace {

void check_same_particles(const fs::path& a, const fs::path& b) {
    const auto first = files_in(a / "points"), second = files_in(b / "points");
    REQUIRE(first.size() == second.size());
    REQUIRE_FALSE(first.empty());
    for (std::size_t k = 0; k < first.size(); ++k) {
        INFO(second[k]);
        CHECK((read_whole(first[k]) == read_whole(second[k])));
    }
}

}  // namespace

TEST_CASE("a run whose end lies between two frames ends with the earlier frame", "[tools][run]") {
    // Its final time equals the frame time exactly.
    const Scratch scratch;
    for (const char* until : {"0.07", "0.13"}) {
        INFO(until);
        const Outcome run = test::whorl(
            {"render", scratch.scene(), "--no-images", "--fps", "24", "--until", until, "--quiet", "--overwrite", "--out", scratch.run()});
        INFO(run.err);
        CHECK(run.code == 0);
    }
}

TEST_CASE("a run writes a row per frame, its probes, its settings and its resources", "[tools][render]") {
    const Scratch scratch;
    const Outcome done = test::whorl({"render", scratch.scene(), "--no-images", "--until", "0.1", "--out", scratch.run(), "--json"});
    INFO(done.err);
    REQUIRE(done.code == 0);
    const auto rows = lines(scratch / "run/diagnostics.csv");
    REQUIRE(rows.size() == 1 + 5);  // the header; 0.1 s at 40 frames a second, both ends
    CHECK(rows[1].substr(0, 4) == "1,0,");
    CHECK(rows[5].substr(0, 6) == "5,0.1,");
    CHECK(lines(scratch / "run/probes/pile.csv").size() == rows.size());
    CHECK(lines(scratch / "run/probes/all.csv").size() == rows.size());
    CHECK_FALSE(fs::exists(scratch / "run/frames"));
    const auto run = report(scratch / "run");
    CHECK(run["status"] == "done");
    CHECK(run["frames"] == 5);
    CHECK(run["particles"] > 512);
    CHECK(run["peak_memory_bytes"] > 1000000);
    CHECK(run["cpu_seconds"] > 0);
    // The last line on standard output is the result.
    const std::string last = done.out.substr(done.out.rfind('\n', done.out.size() - 2) + 1);
    CHECK(nlohmann::json::parse(last)["event"] == "result");

    const Outcome again = test::whorl({"render", scratch.run() + "/scene.resolved.toml", "--out", scratch.run("again"), "--quiet"});
    INFO(again.err);
    REQUIRE(again.code == 0);
    CHECK(again.err.empty());
    CHECK(reproducible(lines(scratch / "again/diagnostics.csv")) == reproducible(rows));
}

TEST_CASE("an interrupted run prints how to continue, and continues bit-identically", "[tools][resume]") {
    const Scratch scratch;
    const std::vector<std::string> arguments{"render", scratch.scene(), "--no-images", "--export", "points", "--quiet", "--out"};
    const auto with = [&](const std::string& folder) {
        auto all = arguments;
        all.push_back(folder);
        return all;
    };
    REQUIRE(test::whorl(with(scratch.run("whole"))).code == 0);

    Program interrupted(with(scratch.run()));
    REQUIRE(interrupted.wait_until([&] { return lines(scratch / "run/diagnostics.csv").size() > 4; }));
    interrupted.signal(SIGINT);
    const Outcome stopped = interrupted.wait();
    CHECK(stopped.code == 130);
    CHECK(stopped.err.find("whorl resume " + scratch.run()) != std::string::npos);
    CHECK(report(scratch / "run")["status"] == "interrupted");
    const std::size_t rows = lines(scratch / "run/diagnostics.csv").size();
    REQUIRE(rows < lines(scratch / "whole/diagnostics.csv").size());

    const Outcome resumed = test::whorl({"resume", scratch.run(), "--quiet"});
    INFO(resumed.err);
    REQUIRE(resumed.code == 0);
    check_same_particles(scratch / "whole", scratch / "run");
    CHECK(reproducible(lines(scratch / "run/diagnostics.csv")) == reproducible(lines(scratch / "whole/diagnostics.csv")));
    for (const char* probe : {"probes/pile.csv", "probes/all.csv"})
        CHECK(read_whole(scratch / "run" / probe) == read_whole(scratch / "whole" / probe));
    const auto run = report(scratch / "run");
    CHECK(run["status"] == "done");
    CHECK(run["resumed"] == 1);
}

TEST_CASE("a finished run continues to a later end, and its saved settings repeat it", "[tools][resume]") {
    const Scratch scratch;
    REQUIRE(
        test::whorl({"render", scratch.scene(), "--no-images", "--export", "points", "--until", "0.1", "--quiet", "--out", scratch.run()})
            .code == 0);
    std::size_t rows = 6;
    for (const auto& [option, value, end] :
         {std::tuple{"--frames", "6", "\nend = 0.125 "}, std::tuple{"--until", "0.15", "\nend = 0.15 "}}) {
        const Outcome longer = test::whorl({"resume", scratch.run(), option, value, "--quiet"});
        INFO(longer.err);
        REQUIRE(longer.code == 0);
        CHECK(lines(scratch / "run/diagnostics.csv").size() == 1 + rows++);
        CHECK(read_whole(scratch / "run/scene.resolved.toml").find(end) != std::string::npos);
    }

    REQUIRE(test::whorl({"render", scratch.run() + "/scene.resolved.toml", "--quiet", "--out", scratch.run("again")}).code == 0);
    check_same_particles(scratch / "run", scratch / "again");
    CHECK(reproducible(lines(scratch / "run/diagnostics.csv")) == reproducible(lines(scratch / "again/diagnostics.csv")));
    // The same holds after another extension, and existing frames are kept.
    CHECK(test::whorl({"resume", scratch.run(), "--quiet"}).code == 0);
    CHECK(lines(scratch / "run/diagnostics.csv").size() == rows);
    const Outcome shorter = test::whorl({"resume", scratch.run(), "--until", "0.05"});
    CHECK(shorter.code == 2);
    CHECK(shorter.err.find("the run has already reached frame") != std::string::npos);
    CHECK(test::whorl({"resume", scratch.run(), "--until", "1", "--frames", "9"}).err.find("use only one of them") != std::string::npos);
}

TEST_CASE("an extension that would change constants is refused, with their names", "[tools][resume]") {
    // Ten times the largest speed that the plan sees until the end: the jet gets faster.
    std::string text = honey;
    text.replace(text.find("speed = \"0.3\""), 13, "speed = \"0.3+40*t\"");
    const Scratch scratch(text);
    REQUIRE(test::whorl({"render", scratch.scene(), "--no-images", "--set", "models.pressure=wcsph", "--set", "fluid.viscosity=0.1",
                         "--until", "0.03", "--quiet", "--out", scratch.run()})
                .code == 0);
    const Outcome refused = test::whorl({"resume", scratch.run(), "--until", "0.1"});
    CHECK(refused.code == 2);
    CHECK(refused.err.find("with time.end = 0.1 s the plan chooses other models or constants than with 0.03 s") != std::string::npos);
    CHECK(refused.err.find("pressure.sound_speed") != std::string::npos);
}

TEST_CASE("an extension continues if only the preconditioner differs, which is chosen per step", "[tools][resume]") {
    const Scratch scratch;
    REQUIRE(test::whorl({"render", scratch.scene(), "--no-images", "--set", "models.pressure=ppe", "--until", "0.025", "--quiet", "--out",
                         scratch.run()})
                .code == 0);
    Options options;
    options.scene = scratch.run() + "/scene.resolved.toml";
    options.until = 600;  // 965 particles per second, and multigrid from half a million on
    RunRequest request;
    request.file = read_scene_file(options);
    request.folder = scratch.run();
    CHECK(make_plan(read_scene_file(options.scene).scene).preconditioner == Preconditioner::jacobi);
    CHECK(make_plan(request.file.scene).preconditioner == Preconditioner::multigrid);
    CHECK_NOTHROW(resume_from_newest(request));
}

TEST_CASE("a film with images left to draw continues when they are drawn, or without images", "[tools][resume]") {
    const Scratch scratch;
    const Outcome slow = test::whorl({"render", scratch.scene(), "--fps", "1e-5", "--out", scratch.run()});  // not needed without a video
    CHECK(slow.code == 2);
    CHECK(slow.err.find("time.fps = 1e-05: too few frames per second for a video; set output.video = false") != std::string::npos);
    REQUIRE(test::whorl({"render", scratch.scene(), "--quality", "draft", "--size", "64x36", "--no-draw", "--until", "0.05", "--quiet",
                         "--out", scratch.run()})
                .code == 0);
    const std::string settings = read_whole(scratch / "run/scene.resolved.toml");
    const std::vector<std::string> longer{"resume", scratch.run(), "--until", "0.075", "--quiet"};
    const Outcome refused = test::whorl(longer);
    CHECK(refused.code == 2);
    CHECK(refused.err.find("the run has no image of frame 1; draw it first: whorl draw " + scratch.run() +
                           "; or continue with --no-draw") != std::string::npos);
    CHECK((read_whole(scratch / "run/scene.resolved.toml") == settings));
    REQUIRE(test::whorl({"draw", scratch.run(), "--quiet"}).code == 0);
    const Outcome drawn = test::whorl(longer);
    CHECK(drawn.err == "");
    CHECK(drawn.code == 0);
    CHECK(files_in(scratch / "run/frames").size() == 4);
}

TEST_CASE("an interrupted run without images reports that it continues without", "[tools][resume]") {
    const Scratch scratch;
    Program program({"render", scratch.scene(), "--quality", "draft", "--size", "64x36", "--no-draw", "--quiet", "--out", scratch.run()});
    REQUIRE(program.wait_until([&] { return lines(scratch / "run/diagnostics.csv").size() > 2; }));
    program.signal(SIGTERM);
    const Outcome stopped = program.wait();
    CHECK(stopped.code == 130);
    CHECK_THAT(stopped.err, Catch::Contains("whorl resume " + scratch.run() + " --no-draw\n"));
}

TEST_CASE("resume refuses other settings by name, and accepts settings that only change images", "[tools][resume]") {
    const Scratch scratch;
    REQUIRE(test::whorl({"render", scratch.scene(), "--no-images", "--until", "0.05", "--quiet", "--out", scratch.run()}).code == 0);
    std::string scene = read_whole(scratch / "run/scene.resolved.toml");
    const auto replace = [&](const std::string& from, const std::string& to) {
        const std::size_t at = scene.find(from);
        REQUIRE(at != std::string::npos);
        scene.replace(at, from.size(), to);
        std::ofstream(scratch / "run/scene.resolved.toml") << scene;
    };
    replace("exposure = 1", "exposure = 2");
    CHECK(test::whorl({"resume", scratch.run(), "--quiet"}).code == 0);
    replace("spacing = 0.0025", "spacing = 0.0026");
    const Outcome refused = test::whorl({"resume", scratch.run()});
    CHECK(refused.code == 2);
    CHECK(refused.err.find("the checkpoint was written with other settings") != std::string::npos);
    CHECK(refused.err.find("fluid.spacing: 0.0025, now 0.0026") != std::string::npos);
}

TEST_CASE("resume refuses a mesh that was edited after the run began, by name, and continues with --force", "[tools][resume]") {
    const Scratch scratch(std::string(honey) + "[[solid]]\nshape = \"mesh\"\nfile = \"wedge.obj\"\n");
    const auto write = [&](const char* corner) {
        std::ofstream(scratch / "wedge.obj") << "v 0 -0.02 0\nv 0.01 -0.02 0\nv 0 " << corner << " 0\nv 0 -0.02 0.01\n"
                                             << "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    };
    write("-0.01");
    REQUIRE(test::whorl({"render", scratch.scene(), "--no-images", "--until", "0.05", "--quiet", "--out", scratch.run()}).code == 0);
    write("-0.009");
    const Outcome refused = test::whorl({"resume", scratch.run(), "--until", "0.1"});
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::StartsWith((scratch / "wedge.obj").string() + ": was edited after the run began"));
    CHECK(test::whorl({"resume", scratch.run(), "--until", "0.1", "--force", "--quiet"}).code == 0);
    CHECK(test::whorl({"resume", scratch.run(), "--until", "0.15", "--quiet"}).code == 0);
}

TEST_CASE("an overfilled box reports how crowded it is", "[tools][render]") {
    const Scratch scratch(test::text::time(0.02, "fps = 100") + test::text::domain({-0.02, -0.02, -0.02}, {0.12, 0.12, 0.12}) +
                          test::text::fluid(0.0125) + test::text::models("ppe", "xsph") + "[pressure]\nform = \"constraint\"\n" +
                          test::text::block({0, 0, 0}, {0.1, 0.1, 0.1}) + test::text::block({0.02, 0.02, 0.02}, {0.08, 0.05, 0.08}) +
                          test::text::tank({0, 0, 0}, {0.1, 0.1, 0.1}));
    const Outcome run = test::whorl({"render", scratch.scene(), "--no-images", "--quiet", "--out", scratch.run()});
    INFO(run.err);
    const auto troubles = report(scratch / "run")["first_troubles"];
    const auto crowded = std::find_if(troubles.begin(), troubles.end(), [](const auto& t) { return t["kind"] == "crowded"; });
    REQUIRE(crowded != troubles.end());
    CHECK((*crowded)["step"] == 1);
    CHECK((*crowded)["what"].template get<std::string>().find("particles are still crowded, one by") != std::string::npos);
}

TEST_CASE("solves that end at their limit are reported once, with residual and key, and counted at the end", "[tools][render]") {
    const auto said = [](const std::string& text, const std::string& part) {
        std::size_t count = 0;
        for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
        return count;
    };
    const std::string ppe = "[models]\npressure = \"ppe\"\nviscosity = \"full\"\n", coupled = "[models]\npressure = \"coupled\"\n";
    for (const auto& [models, name, key] : {std::tuple{ppe + "[pressure]\nmax_iterations = 1\n", "pressure", "pressure"},
                                            std::tuple{ppe + "[viscosity]\nmax_iterations = 1\n", "viscosity", "viscosity"},
                                            std::tuple{coupled + "[pressure]\nmax_iterations = 1\n", "coupled", "pressure"}}) {
        INFO(models);
        const Scratch scratch(
            "name = \"short\"\n[time]\nend = 0.02\nfps = 100\n[domain]\nmin = [-0.02, -0.02, -0.02]\nmax = [0.12, 0.12, 0.12]\n"
            "[fluid]\nspacing = 0.01\nviscosity = 10\n[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.05, 0.1, 0.05]\n"
            "velocity = [\"y\", \"0\", \"0\"]\n[[solid]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.05]\ncontainer = true\n" +
            models);
        const Outcome run = test::whorl({"render", scratch.scene(), "--no-images", "--quiet", "--out", scratch.run()});
        INFO(run.err);
        CHECK(said(run.err, "unfinished solve at ") == 1);
        CHECK(said(run.err, std::string(name) + ": residual ") == 1);
        CHECK(said(run.err, std::string("; raise ") + key + ".max_iterations") == 1);
        CHECK(said(run.err, "ended before their tolerance") == 1);
    }
}

TEST_CASE("a change of gravity that needs other models is refused, with the key to set", "[tools][render]") {
    const std::string text =
        "[time]\nend = 0.02\nfps = 100\n[domain]\nmin = [-0.1, -0.1, -0.1]\nmax = [0.1, 0.1, 0.1]\ngravity = [0, 0, 0]\n[fluid]\n"
        "spacing = 0.01\nviscosity = 8\n[[block]]\nshape = \"box\"\nmin = [-0.05, -0.05, -0.05]\nmax = [0.05, 0.02, 0.05]\n[[change]]\n"
        "time = 0.01\nkey = \"domain.gravity\"\nvalue = [0, -9.81, 0]\n";
    const Scratch refused(text), given(text + "[models]\npressure = \"coupled\"\n");
    const Outcome run = test::whorl({"render", refused.scene(), "--no-images", "--quiet", "--out", refused.run()});
    INFO(run.err);
    CHECK(run.code == 2);
    CHECK(run.err.find("models.pressure: \"coupled\", now \"ppe\"") != std::string::npos);
    CHECK(run.err.find("set models.pressure in the scene") != std::string::npos);
    CHECK(test::whorl({"render", given.scene(), "--no-images", "--quiet", "--out", given.run()}).code == 0);
}

TEST_CASE("a drop of 20 micrometres can be rendered", "[tools][render]") {
    const Scratch scratch;
    std::ofstream(scratch / "drop.toml")
        << "[time]\nend = 2e-6\nslow_motion = 4e4\n[domain]\nmin = [-2e-5, -4e-6, -2e-5]\nmax = [2e-5, 4e-5, 2e-5]\n[fluid]\nspacing = "
           "2e-6\n"
           "viscosity = 1e-3\nsurface_tension = 0.07\n[[block]]\nshape = \"sphere\"\nposition = [0, 1.2e-5, 0]\nradius = 1e-5\n"
           "velocity = [0, -1, 0]\n[[solid]]\nshape = \"box\"\nmin = [-2e-5, -4e-6, -2e-5]\nmax = [2e-5, 0, 2e-5]\n";
    const Outcome done =
        test::whorl({"render", scratch / "drop.toml", "--out", scratch.run(), "--quality", "draft", "--size", "64x36", "--no-video"});
    INFO(done.err);
    REQUIRE(done.code == 0);
    CHECK(files_in(scratch / "run/frames").size() == 2);
    CHECK(report(scratch / "run")["particles"] > 400);
}

TEST_CASE("a run completes in a folder named like a protocol, and if SIGCHLD is ignored", "[tools][render]") {
    const Scratch scratch;
    const std::string program = "trap '' CHLD; cd " + scratch.path().string() + " && exec " + WHORL_PROGRAM +
                                " render scene.toml --frames 2 --size 64x36 --quiet --out 2024-01-01T12:00";
    const Outcome run = test::Program({"-c", program}, "bash").wait();
    INFO(run.err);
    CHECK(run.code == 0);
    CHECK(report(scratch / "2024-01-01T12:00")["status"] == "done");
    const auto made = files_in(scratch / "2024-01-01T12:00");
    CHECK(std::count_if(made.begin(), made.end(), [](const fs::path& file) { return file.extension() == ".mp4"; }) == 1);
}

TEST_CASE("a diverging run reports position and time, exits with 1 and keeps its files", "[tools][render]") {
    std::string text = honey;
    const std::size_t viscosity = text.find("viscosity");
    text.replace(viscosity, text.find('\n', viscosity) - viscosity, std::string("viscosity = \"") + test::diverging_viscosity + "\"");
    const Scratch scratch(text);
    const Outcome diverged = test::whorl({"render", scratch.scene(), "--no-images", "--quiet", "--out", scratch.run()});
    CHECK(diverged.code == 1);
    INFO(diverged.err);
    CHECK(diverged.err.find("the run diverged at 0.0") != std::string::npos);
    CHECK(diverged.err.find("stage") != std::string::npos);
    CHECK(report(scratch / "run")["status"] == "diverged");
    CHECK(lines(scratch / "run/diagnostics.csv").size() >= 1 + 3);
}

TEST_CASE("a killed render leaves valid pictures and a playable video, and resume completes both", "[tools][resume]") {
    const Scratch scratch;
    const std::vector<std::string> arguments{"render",  scratch.scene(), "--until",    "0.25",  "--size",
                                             "160x90",  "--quality",     "draft",      "--set", "output.checkpoint_every=0.001",
                                             "--quiet", "--out",         scratch.run()};
    Program killed(arguments);
    const bool started = killed.wait_until([&] { return fs::exists(scratch / "run/frames/000004.png"); });
    killed.signal(SIGKILL);
    const Outcome outcome = killed.wait();
    INFO(outcome.err);
    REQUIRE(started);
    CHECK(outcome.code == 128 + SIGKILL);

    const auto valid_pictures = [&] {
        int count = 0;
        for (const fs::path& file : files_in(scratch / "run/frames"))
            if (file.stem().extension().empty()) count += read_png(file).width == 160;
        return count;
    };
    const auto playable_frames = [&](const std::string& video) {
        const Outcome probe = Program({"-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries", "stream=nb_read_frames",
                                       "-of", "csv=p=0", (scratch / "run" / video).string()},
                                      "ffprobe")
                                  .wait();
        CHECK(probe.err.empty());
        return probe.code == 0 ? std::stoi("0" + probe.out) : -1;
    };
    const int before = valid_pictures();
    CHECK(before >= 4);
    // The encoder sees its input end and completes the file; give it a moment.
    Program patience({"1"}, "sleep");
    patience.wait_until([&] { return false; });
    CHECK(playable_frames(".little_honey.mp4.partial") >= 1);

    const Outcome resumed = test::whorl({"resume", scratch.run(), "--quiet"});
    INFO(resumed.err);
    REQUIRE(resumed.code == 0);
    CHECK(valid_pictures() == 11);
    CHECK(playable_frames("little_honey.mp4") == 11);
    CHECK_FALSE(fs::exists(scratch / "run/.little_honey.mp4.partial"));
    CHECK(read_png(scratch / "run/contact.png").width > 0);
    CHECK(test::whorl({"video", scratch.run(), "--out", (scratch / "again.mp4").string()}).code == 0);
    CHECK(fs::exists(scratch / "again.mp4"));
}

TEST_CASE("a run without a checkpoint restarts, and equals an uninterrupted run", "[tools][resume]") {
    const Scratch scratch;
    const auto arguments = [&](const std::string& name, const std::string& frames) {
        return std::vector<std::string>{"render",
                                        scratch.scene(),
                                        "--frames",
                                        frames,
                                        "--size",
                                        "64x36",
                                        "--set",
                                        "look.samples=1",
                                        "--export",
                                        "points",
                                        "--quiet",
                                        "--set",
                                        "output.checkpoint_every=1000",
                                        "--out",
                                        scratch.run(name)};
    };
    REQUIRE(test::whorl(arguments("whole", "4")).code == 0);
    Program killed(arguments("run", "4"));
    REQUIRE(killed.wait_until([&] { return fs::exists(scratch / "run/run.json"); }));
    killed.signal(SIGKILL);
    killed.wait();
    for (const char* made : {"checkpoints", "points", "frames"}) fs::remove_all(scratch / "run" / made);
    auto state = report(scratch / "run");
    const auto write = [&](const char* status, int frames) {
        state["status"] = status, state["frames"] = frames;
        std::ofstream(scratch / "run/run.json") << state;
    };
    // Its end is set by --frames; the end in the scene is unchanged.
    const int all = state.at("frames_of_scene");
    for (const auto& [planned, of_scene, wanted] :
         std::vector<std::tuple<nlohmann::json, int, int>>{{3, 3, all}, {4, 5, all}, {"x", all, all}, {4, all, 4}}) {
        state["frames_planned"] = planned, state["frames_of_scene"] = of_scene;
        write("running", 0);
        RunRequest request;
        request.file = read_scene_file(scratch / "run/scene.resolved.toml");
        request.folder = scratch.run();
        resume_from_newest(request);
        CHECK(request.frames == wanted);
    }
    std::ofstream(scratch / "run/final_cut.mp4") << "keep";
    const Outcome resumed = test::whorl({"resume", scratch.run(), "--quiet"});
    CHECK(resumed.err == "no checkpoint yet: the run restarts\n");
    REQUIRE(resumed.code == 0);
    check_same_particles(scratch / "whole", scratch / "run");
    CHECK(reproducible(lines(scratch / "whole/diagnostics.csv")) == reproducible(lines(scratch / "run/diagnostics.csv")));
    REQUIRE(files_in(scratch / "run/frames").size() == 4);
    for (const char* same : {"frames/000004.png", "little_honey.mp4"})
        CHECK((read_whole(scratch / "run" / same) == read_whole(scratch / "whole" / same)));
    CHECK(fs::exists(scratch / "run/final_cut.mp4"));
    // A run that had a checkpoint stays untouched. The frames of a killed run are made again. Videos of other runs stay.
    const auto again = [&](const std::string& name) { return test::whorl({"resume", scratch.run(name), "--frames", "2", "--quiet"}); };
    fs::remove_all(scratch / "run/checkpoints");
    write("interrupted", 3);
    const Outcome refused = again("run");
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::Contains("no valid checkpoint to continue from; render the scene again"));
    CHECK(files_in(scratch / "run/frames").size() == 4);
    fs::copy(scratch / "run", scratch / "torn");
    fs::copy(scratch / "run", scratch / "killed", fs::copy_options::recursive);
    std::ofstream(scratch / "torn/run.json") << "{\"who";
    CHECK(again("torn").code == 0);
    CHECK(read_whole(scratch / "torn/final_cut.mp4") == "keep");
    write("running", 3);
    fs::copy(scratch / "run/run.json", scratch / "killed/run.json", fs::copy_options::overwrite_existing);
    CHECK(again("killed").code == 0);
    CHECK(files_in(scratch / "killed/frames").size() == 2);
    // A finished run stays unchanged.
    write("done", 4);
    const Outcome done = test::whorl({"resume", scratch.run()});
    CHECK(done.code == 2);
    CHECK_THAT(done.err, Catch::EndsWith("the run is done and has no checkpoint to continue from; render the scene again\n"));
    CHECK(files_in(scratch / "run/frames").size() == 4);
}

TEST_CASE("a run whose folder is removed reports it, and resumes when the folder is back", "[tools][resume]") {
    const Scratch scratch;
    Program program({"render", scratch.scene(), "--size", "64x36", "--no-video", "--quiet", "--out", scratch.run()});
    REQUIRE(program.wait_until([&] { return fs::exists(scratch / "run/frames/000002.png"); }));
    fs::rename(scratch / "run", scratch / "taken");
    const Outcome gone = program.wait();
    CHECK(gone.code == 1);
    CHECK_THAT(gone.err, Catch::StartsWith("whorl: the folder " + scratch.run() + " was removed or renamed while the run was at work\n"));
    fs::rename(scratch / "taken", scratch / "run");
    CHECK(test::whorl({"resume", scratch.run(), "--quiet"}).code == 0);
}

TEST_CASE("a run chooses and stores the colour range of particles at the start, unless it is set", "[tools][render]") {
    const Scratch scratch;
    const auto range_of = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"render", scratch.scene(), "--frames",    "1",     "--no-video",           "--size",
                                           "64x36",  "--out",         scratch.run(), "--set", "look.style=particles", "--overwrite"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome done = test::whorl(arguments);
        INFO(done.err);
        REQUIRE(done.code == 0);
        for (const std::string& line : lines(scratch / "run/scene.resolved.toml"))
            if (line.rfind("range", 0) == 0) return line.substr(line.find('['), line.find(']') + 1 - line.find('['));
        return std::string();
    };
    // The range is that of the whole run, also for a test of one frame: .25 m/s in the nozzle. The heavy thread hardly accelerates in its
    // fall of 45 mm.
    CHECK(range_of({"--set", "emitter[0].speed=0.25"}) == "[0.0, 0.3]");
    CHECK(range_of({"--set", "look.range=[0, 2]"}) == "[0.0, 2.0]");
}

TEST_CASE("a stage's CPU time excludes other work of its thread", "[tools]") {
    const auto work = [](double seconds) {
        const double began = simulation_cpu_seconds();
        while (simulation_cpu_seconds() - began < seconds) {}
        return true;
    };
    RunTimes times;
    work(0.1);
    times.simulate([&] { return work(0.05); });
    work(0.1);
    const StageTimes stages = times.stages({{"move", {0.02, 0, 1}}, {"pressure", {0.03, 0, 1}}}, {});
    // 0.05 s by the scheduler's count, which may lag by a tick of 4 ms.
    CHECK(stages.at("move").cpu == Approx(0.02).margin(0.004));
    CHECK(stages.at("pressure").cpu == Approx(0.03).margin(0.004));
}

}  // namespace run_test

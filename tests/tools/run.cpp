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
        scratch.render({"--no-images", "--fps", "24", "--until", until, "--overwrite"});
    }
}

TEST_CASE("a run writes a row per frame, its probes, its settings and its resources", "[tools][render]") {
    const Scratch scratch;
    const Outcome done = test::succeed({"render", scratch.scene(), "--no-images", "--until", "0.1", "--out", scratch.run(), "--json"});
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

    CHECK(test::succeed({"render", scratch.run() + "/scene.resolved.toml", "--out", scratch.run("again"), "--quiet"}).err.empty());
    CHECK(reproducible(lines(scratch / "again/diagnostics.csv")) == reproducible(rows));
}

TEST_CASE("an interrupted run prints how to continue, and continues bit-identically", "[tools][resume]") {
    const Scratch scratch;
    scratch.render({"--no-images", "--export", "points"}, "whole");
    Program interrupted({"render", scratch.scene(), "--no-images", "--export", "points", "--quiet", "--out", scratch.run()});
    REQUIRE(interrupted.wait_until([&] { return lines(scratch / "run/diagnostics.csv").size() > 4; }));
    interrupted.signal(SIGINT);
    const Outcome stopped = interrupted.wait();
    CHECK(stopped.code == 130);
    CHECK(stopped.err.find("whorl resume " + scratch.run()) != std::string::npos);
    CHECK(report(scratch / "run")["status"] == "interrupted");
    const std::size_t rows = lines(scratch / "run/diagnostics.csv").size();
    REQUIRE(rows < lines(scratch / "whole/diagnostics.csv").size());

    test::succeed({"resume", scratch.run(), "--quiet"});
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
    scratch.render({"--no-images", "--export", "points", "--until", "0.1"});
    std::size_t rows = 6;
    for (const auto& [option, value, end] :
         {std::tuple{"--frames", "6", "\nend = 0.125 "}, std::tuple{"--until", "0.15", "\nend = 0.15 "}}) {
        test::succeed({"resume", scratch.run(), option, value, "--quiet"});
        CHECK(lines(scratch / "run/diagnostics.csv").size() == 1 + rows++);
        CHECK(read_whole(scratch / "run/scene.resolved.toml").find(end) != std::string::npos);
    }

    test::succeed({"render", scratch.run() + "/scene.resolved.toml", "--quiet", "--out", scratch.run("again")});
    check_same_particles(scratch / "run", scratch / "again");
    CHECK(reproducible(lines(scratch / "run/diagnostics.csv")) == reproducible(lines(scratch / "again/diagnostics.csv")));
    // The same holds after another extension, and existing frames are kept.
    test::succeed({"resume", scratch.run(), "--quiet"});
    CHECK(lines(scratch / "run/diagnostics.csv").size() == rows);
    CHECK_THAT(test::refusal({"resume", scratch.run(), "--until", "0.05"}), Catch::Contains("the run has already reached frame"));
    CHECK(test::whorl({"resume", scratch.run(), "--until", "1", "--frames", "9"}).err.find("use only one of them") != std::string::npos);
}

TEST_CASE("an extension that would change constants is refused, with their names", "[tools][resume]") {
    // Ten times the largest speed that the plan sees until the end: the jet gets faster.
    std::string text = honey;
    text.replace(text.find("speed = 0.3"), 11, "speed = \"0.3+40*t\"");
    const Scratch scratch(text);
    scratch.render({"--no-images", "--set", "models.pressure=wcsph", "--set", "fluid.viscosity=0.1", "--until", "0.01"});
    const std::string refused = test::refusal({"resume", scratch.run(), "--until", "0.1"});
    CHECK(refused.find("with time.end = 0.1 s the plan chooses other models or constants than with 0.01 s") != std::string::npos);
    CHECK(refused.find("pressure.sound_speed") != std::string::npos);
}

TEST_CASE("an extension continues if only the preconditioner differs, which is chosen per step", "[tools][resume]") {
    const Scratch scratch;
    scratch.render({"--no-images", "--set", "models.pressure=ppe", "--until", "0.025"});
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
    CHECK_THAT(test::refusal({"render", scratch.scene(), "--fps", "1e-5", "--out", scratch.run()}),
               Catch::Contains("time.fps = 1e-05: too few frames per second for a video; set output.video = false"));
    scratch.render({"--quality", "draft", "--size", "64x36", "--no-draw", "--until", "0.05"});
    const std::string settings = read_whole(scratch / "run/scene.resolved.toml");
    const std::vector<std::string> longer{"resume", scratch.run(), "--until", "0.075", "--quiet"};
    CHECK_THAT(test::refusal(longer), Catch::Contains("the run has no image of frame 1; draw it first: whorl draw " + scratch.run() +
                                                      "; or continue with --no-draw"));
    CHECK((read_whole(scratch / "run/scene.resolved.toml") == settings));
    test::succeed({"draw", scratch.run(), "--quiet"});
    CHECK(test::succeed(longer).err == "");
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
    scratch.render({"--no-images", "--until", "0.05"});
    std::string scene = read_whole(scratch / "run/scene.resolved.toml");
    const auto replace = [&](const std::string& from, const std::string& to) {
        const std::size_t at = scene.find(from);
        REQUIRE(at != std::string::npos);
        scene.replace(at, from.size(), to);
        std::ofstream(scratch / "run/scene.resolved.toml") << scene;
    };
    replace("exposure = 1", "exposure = 2");
    test::succeed({"resume", scratch.run(), "--quiet"});
    replace("spacing = 0.0025", "spacing = 0.0026");
    const std::string refused = test::refusal({"resume", scratch.run()});
    CHECK(refused.find("the checkpoint was written with other settings") != std::string::npos);
    CHECK(refused.find("fluid.spacing: 0.0025, now 0.0026") != std::string::npos);
}

TEST_CASE("resume refuses a mesh that was edited after the run began, by name, and continues with --force", "[tools][resume]") {
    const Scratch scratch(std::string(honey) + "[[solid]]\nshape = \"mesh\"\nfile = \"wedge.obj\"\n");
    const auto write = [&](const char* corner) {
        std::ofstream(scratch / "wedge.obj") << "v 0 -0.02 0\nv 0.01 -0.02 0\nv 0 " << corner << " 0\nv 0 -0.02 0.01\n"
                                             << "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    };
    write("-0.01");
    scratch.render({"--no-images", "--until", "0.05"});
    write("-0.009");
    CHECK_THAT(test::refusal({"resume", scratch.run(), "--until", "0.1"}),
               Catch::StartsWith((scratch / "wedge.obj").string() + ": was edited after the run began"));
    test::succeed({"resume", scratch.run(), "--until", "0.1", "--force", "--quiet"});
    test::succeed({"resume", scratch.run(), "--until", "0.15", "--quiet"});
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
    const std::string ppe = test::text::models("ppe", "full"), coupled = test::text::models("coupled");
    for (const auto& [models, name, key] : {std::tuple{ppe + "[pressure]\nmax_iterations = 1\n", "pressure", "pressure"},
                                            std::tuple{ppe + "[viscosity]\nmax_iterations = 1\n", "viscosity", "viscosity"},
                                            std::tuple{coupled + "[pressure]\nmax_iterations = 1\n", "coupled", "pressure"}}) {
        INFO(models);
        const Scratch scratch(test::text::time(0.02, "fps = 100") + test::text::domain({-0.02, -0.02, -0.02}, {0.12, 0.12, 0.12}) +
                              test::text::fluid(0.01, 10) +
                              test::text::block({0, 0, 0}, {0.05, 0.1, 0.05}, "velocity = [\"y\", \"0\", \"0\"]") +
                              test::text::tank({0, 0, 0}, {0.1, 0.1, 0.05}) + models);
        const Outcome run = test::whorl({"render", scratch.scene(), "--no-images", "--quiet", "--out", scratch.run()});
        INFO(run.err);
        CHECK(said(run.err, "unfinished solve at ") == 1);
        CHECK(said(run.err, std::string(name) + ": residual ") == 1);
        CHECK(said(run.err, std::string("; raise ") + key + ".max_iterations") == 1);
        CHECK(said(run.err, "ended before their tolerance") == 1);
    }
}

TEST_CASE("a change of gravity that needs other models is refused, with the key to set", "[tools][render]") {
    const std::string text = test::text::time(0.02, "fps = 100") +
                             test::text::domain({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, "gravity = [0, 0, 0]") + test::text::fluid(0.01, 8) +
                             test::text::block({-0.05, -0.05, -0.05}, {0.05, 0.02, 0.05}) +
                             "[[change]]\ntime = 0.01\nkey = \"domain.gravity\"\nvalue = [0, -9.81, 0]\n";
    const Scratch refused(text), given(text + "[models]\npressure = \"coupled\"\n");
    const Outcome run = test::whorl({"render", refused.scene(), "--no-images", "--quiet", "--out", refused.run()});
    INFO(run.err);
    CHECK(run.code == 2);
    CHECK(run.err.find("models.pressure: \"coupled\", now \"ppe\"") != std::string::npos);
    CHECK(run.err.find("set models.pressure in the scene") != std::string::npos);
    test::succeed({"render", given.scene(), "--no-images", "--quiet", "--out", given.run()});
}

TEST_CASE("a drop of 20 micrometres can be rendered", "[tools][render]") {
    const Scratch scratch(test::text::time(2e-6, "slow_motion = 4e4") + test::text::domain({-2e-5, -4e-6, -2e-5}, {2e-5, 4e-5, 2e-5}) +
                          test::text::fluid(2e-6, 1e-3, "surface_tension = 0.07") +
                          test::text::drop({0, 1.2e-5, 0}, 1e-5, "velocity = [0, -1, 0]") +
                          test::text::box({-2e-5, -4e-6, -2e-5}, {2e-5, 0, 2e-5}));
    scratch.render({"--quality", "draft", "--size", "64x36", "--no-video"});
    CHECK(files_in(scratch / "run/frames").size() == 2);
    CHECK(report(scratch / "run")["particles"] > 400);
}

TEST_CASE("a run completes in a folder named like a protocol, and if SIGCHLD is ignored", "[tools][render]") {
    const Scratch scratch;
    const std::string program = "trap '' CHLD; cd " + scratch.path().string() + " && exec " + WHORL_PROGRAM +
                                " render scene.toml --frames 2 --size 64x36 --quiet --out 2024-01-01T12:00";
    test::succeed(test::Program({"-c", program}, "bash").wait());
    CHECK(report(scratch / "2024-01-01T12:00")["status"] == "done");
    const auto made = files_in(scratch / "2024-01-01T12:00");
    CHECK(std::count_if(made.begin(), made.end(), [](const fs::path& file) { return file.extension() == ".mp4"; }) == 1);
}

TEST_CASE("a diverging run reports position and time, exits with 1 and keeps its files", "[tools][render]") {
    const Scratch scratch;
    const std::string set = std::string("fluid.viscosity=") + test::diverging_viscosity;
    const Outcome diverged = test::whorl({"render", scratch.scene(), "--set", set, "--no-images", "--quiet", "--out", scratch.run()});
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

    test::succeed({"resume", scratch.run(), "--quiet"});
    CHECK(valid_pictures() == 11);
    CHECK(playable_frames("little_honey.mp4") == 11);
    CHECK_FALSE(fs::exists(scratch / "run/.little_honey.mp4.partial"));
    CHECK(read_png(scratch / "run/contact.png").width > 0);
    test::succeed({"video", scratch.run(), "--out", (scratch / "again.mp4").string()});
    CHECK(fs::exists(scratch / "again.mp4"));
}

TEST_CASE("a run without a checkpoint restarts, and equals an uninterrupted run", "[tools][resume]") {
    const Scratch scratch;
    std::vector<std::string> words{"--frames",       "4",        "--size", "64x36", "--set",
                                   "look.samples=1", "--export", "points", "--set", "output.checkpoint_every=1000"};
    scratch.render(words, "whole");
    words.insert(words.begin(), {"render", scratch.scene(), "--quiet", "--out", scratch.run()});
    Program killed(words);
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
    CHECK_THAT(test::refusal(again("run")), Catch::Contains("no valid checkpoint to continue from; render the scene again"));
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
    CHECK_THAT(test::refusal({"resume", scratch.run()}),
               Catch::EndsWith("the run is done and has no checkpoint to continue from; render the scene again\n"));
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
    test::succeed({"resume", scratch.run(), "--quiet"});
}

TEST_CASE("a run chooses and stores the colour range of particles at the start, unless it is set", "[tools][render]") {
    const Scratch scratch;
    const auto range_of = [&](const std::string& set) {
        scratch.render({"--frames", "1", "--no-video", "--size", "64x36", "--set", "look.style=particles", "--overwrite", "--set", set});
        for (const std::string& line : lines(scratch / "run/scene.resolved.toml"))
            if (line.rfind("range", 0) == 0) return line.substr(line.find('['), line.find(']') + 1 - line.find('['));
        return std::string();
    };
    // The range is that of the whole run, also for a test of one frame: .25 m/s in the nozzle. The heavy thread hardly accelerates in its
    // fall of 45 mm.
    CHECK(range_of("emitter[0].speed=0.25") == "[0.0, 0.3]");
    CHECK(range_of("look.range=[0, 2]") == "[0.0, 2.0]");
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

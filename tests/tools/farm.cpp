#include <signal.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/io/csv.h"
#include "tests/support/program.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"

using namespace whorl;
using test::Outcome;
namespace fs = std::filesystem;

namespace farm_test {

namespace {

struct Scratch : test::ScratchFolder {
    explicit Scratch(const std::string& panels = "") {
        std::ofstream(*this / "scene.toml") << test::little_honey("end = 0.2\nfps = 40", 4e-3,
                                                                  test::lump_and_thread + std::string(R"([[solid]]
shape = "plane"
[output]
size = [132, 64]
[look]
samples = 1
style = "particles"
field = "speed"
)")) << panels;
    }
    /// Another scene of this name, with another line for a key; returns its path.
    std::string variant(const std::string& name, const std::string& key, const std::string& line) const {
        std::string text = read_whole(*this / "scene.toml");
        text.replace(text.find("little_honey"), 12, name);
        text.replace(text.find(key), text.find('\n', text.find(key)) - text.find(key), line);
        std::ofstream(*this / (name + ".toml")) << text;
        return *this / (name + ".toml");
    }
    Outcome whorl(std::vector<std::string> words, const std::string& out) const {
        words.insert(words.begin() + 1, (*this / "scene.toml").string());
        words.insert(words.end(), {"--threads", "1", "--out", (*this / out).string()});
        return test::whorl(words);
    }
};

void check_same_pictures(const fs::path& a, const fs::path& b, std::size_t count) {
    std::size_t pictures = 0;
    for (const auto& entry : fs::directory_iterator(a / "frames")) {
        const fs::path other = b / "frames" / entry.path().filename();
        INFO(other);
        REQUIRE(fs::exists(other));
        CHECK((read_whole(entry.path()) == read_whole(other)));
        ++pictures;
    }
    CHECK(pictures == count);
}

}  // namespace

TEST_CASE("a scene simulated once and drawn in pieces is bit-identical to a single run", "[tools][farm]") {
    const Scratch scratch;
    REQUIRE(scratch.whorl({"render", "--quiet", "--export", "scene,vtk,mesh"}, "whole").code == 0);
    CHECK_THAT(test::succeed(scratch.whorl({"farm", "--on", "local", "--pieces", "3", "--export", "scene,vtk,mesh"}, "farmed")).err,
               Catch::Contains("simulate 1 of 1, draw 3 of 3, encode 1 of 1"));
    check_same_pictures(scratch / "whole", scratch / "farmed", 9);
    CHECK(fs::exists(scratch / "farmed/little_honey.mp4"));
    CHECK(fs::exists(scratch / "farmed/contact.png"));
    CHECK(read_whole(scratch / "farmed/farm/simulate.0.log").empty());  // replaces no files
    for (const char* file : {"scene/little_honey.glb", "vtk/little_honey.pvd", "mesh/little_honey.0005.ply"})
        CHECK((read_whole(scratch / "farmed" / file) == read_whole(scratch / "whole" / file)));
    // Equal settings, except that it keeps frames.
    std::string kept = read_whole(scratch / "farmed/scene.resolved.toml"), plain = read_whole(scratch / "whole/scene.resolved.toml");
    for (std::string* text : {&kept, &plain})
        text->erase(text->find("\nexport = "), text->find('\n', text->find("\nexport = ") + 1) - text->find("\nexport = "));
    CHECK(kept == plain);
}

TEST_CASE("panels are separate runs, put side by side at the end", "[tools][farm]") {
    const Scratch scratch(
        "[[panel]]\nlabel = \"thick\"\n[[panel]]\nlabel = \"thin\"\nset = [\"fluid.viscosity=60\", \"fluid.density=40000\"]\n");
    REQUIRE(scratch.whorl({"render", "--quiet"}, "whole").code == 0);
    const Outcome farmed = test::succeed(scratch.whorl({"farm"}, "farmed"));
    CHECK(farmed.err.find("panels 2 of 2, gather 1 of 1") != std::string::npos);
    CHECK(farmed.err.find("warning: panel 2: fluid.density = 40000: liquids have") != std::string::npos);
    check_same_pictures(scratch / "whole", scratch / "farmed", 9);
    CHECK(nlohmann::json::parse(read_whole(scratch / "farmed/run.json")).at("status") == "done");
}

TEST_CASE("a farm reports the failed task with its output, and refuses an unknown place", "[tools][farm]") {
    const Scratch scratch;
    const Outcome diverged =
        scratch.whorl({"farm", "--no-images", "--set", std::string("fluid.viscosity=") + test::diverging_viscosity}, "diverged");
    CHECK(diverged.code == 1);
    CHECK(diverged.err.find("simulate, little_honey: ended with 1: ") != std::string::npos);
    CHECK(diverged.err.find("diverged at 0.") != std::string::npos);
    CHECK(diverged.err.find("diverged/farm/simulate.0.log") != std::string::npos);
    CHECK_THAT(test::refusal(scratch.whorl({"farm", "--on", "slrum"}, "nowhere")), Catch::Contains("did you mean \"slurm\"?"));
    CHECK_THAT(scratch.whorl({"farm", "--jobs", "2"}, "nowhere").err, Catch::Contains("--jobs: has no effect with --on local"));
    CHECK_FALSE(fs::exists(scratch / "nowhere"));
}

TEST_CASE("a failing scene does not stop the others of a farm, and is named at the end", "[tools][farm]") {
    const Scratch scratch;
    const std::string bad = scratch.variant("bad", "viscosity", std::string("viscosity = \"") + test::diverging_viscosity + "\"");
    const Outcome farmed = scratch.whorl({"farm", bad, "--pieces", "2"}, "films");
    INFO(farmed.err);
    CHECK(farmed.code == 1);
    CHECK(farmed.err.find("simulate, bad: ended with 1: ") != std::string::npos);
    CHECK(farmed.err.find("draw, ") == std::string::npos);
    CHECK(farmed.err.find("simulate 2 of 2, draw 2 of 4, encode 1 of 2") != std::string::npos);
    CHECK(farmed.out == (scratch / "films/little_honey").string() + "\n");
    CHECK(fs::exists(scratch / "films/little_honey/little_honey.mp4"));
    CHECK_FALSE(fs::exists(scratch / "films/bad/farm/draw.0.log"));
}

TEST_CASE("one invalid scene stops all at the start, and an interrupted farm prints how to continue", "[tools][farm]") {
    const Scratch scratch;
    const std::string huge = scratch.variant("huge", "spacing", "spacing = 1e-7");
    test::refusal(scratch.whorl({"farm", huge}, "films"));
    CHECK_FALSE(fs::exists(scratch / "films"));
    // Also if the folder of the second is not available: the first keeps its existing run.
    for (const char* name : {"little_honey", "huge"}) fs::create_directories(scratch / "films" / name);
    for (const char* file : {"little_honey/scene.resolved.toml", "huge/thesis.txt"}) std::ofstream(scratch / "films" / file) << "# text";
    const auto together = [&] { return scratch.whorl({"farm", "--overwrite", huge}, "films").err; };
    CHECK_THAT(together(), Catch::Contains("films/huge: the folder contains files but no run"));
    fs::remove(scratch / "films/huge/thesis.txt");
    {
        const RunFolder held = RunFolder::any(scratch / "films/huge");
        CHECK_THAT(together(), Catch::Contains("films/huge: another run is at work in this folder"));
    }
    CHECK(read_whole(scratch / "films/little_honey/scene.resolved.toml") == "# text");

    const std::string run = (scratch / "run").string();
    test::Program farm({"farm", (scratch / "scene.toml").string(), "--threads", "1", "--until", "2", "--out", run});
    REQUIRE(farm.wait_until([&] { return fs::exists(scratch / "run/raw/000002.frame"); }));
    farm.signal(SIGINT);
    const Outcome stopped = farm.wait();
    CHECK(stopped.code == 130);
    CHECK(stopped.err.find("whorl: little_honey was interrupted; continue with: whorl resume " + run + " --no-draw, then whorl draw " +
                           run + "\n") != std::string::npos);
    const std::string short_film = std::to_string(exported_frames(run).size() + 2);
    test::succeed({"resume", run, "--no-draw", "--frames", short_film, "--quiet"});
    test::succeed({"draw", run, "--quiet"});
    CHECK(fs::exists(scratch / "run/little_honey.mp4"));
}

TEST_CASE("a film with a diverging panel is the same from a farm and from a local run", "[tools][farm]") {
    const Scratch scratch(std::string("[[panel]]\n[[panel]]\nset = [\"fluid.viscosity=") + test::diverging_viscosity + "\"]\n");
    const Outcome whole = scratch.whorl({"render", "--quiet"}, "whole"), farmed = scratch.whorl({"farm"}, "farmed");
    INFO(farmed.err);
    CHECK(whole.code == 1);
    CHECK(farmed.code == 1);
    const auto report = [&](const char* run) { return nlohmann::json::parse(read_whole(scratch / run / "run.json")); };
    CHECK(report("farmed").at("status") == "diverged");
    check_same_pictures(scratch / "whole", scratch / "farmed", report("whole").at("frames"));
}

TEST_CASE("a task continues from its checkpoint, and fails instead of restarting if it cannot", "[tools][farm]") {
    const Scratch scratch;
    REQUIRE(scratch.whorl({"farm", "--no-images"}, "run").code == 0);
    const std::string rows = read_whole(scratch / "run/diagnostics.csv");
    for (const auto& entry : fs::directory_iterator(scratch / "run/checkpoints")) std::ofstream(entry.path()) << "of another build";
    const auto again = [&] { return test::Program({(scratch / "run/farm/simulate.sh").string(), "0"}, "bash").wait().code; };
    CHECK(again() == 2);
    CHECK(read_whole(scratch / "run/diagnostics.csv") == rows);
    fs::remove_all(scratch / "run/checkpoints");
    CHECK(again() == 0);
    CHECK_THAT(test::refusal(test::Program({(scratch / "run/farm/simulate.sh").string(), "1"}, "bash").wait()),
               Catch::Contains("unknown task 1: 0 to 0"));
    CHECK(!fs::exists(scratch / "run/farm/simulate.1.code"));
}

TEST_CASE("while jobs of a farm run, another farm in its folder is refused", "[tools][farm]") {
    const Scratch scratch;
    const auto program = [&](const char* name, const std::string& does) {
        std::ofstream(scratch / name) << "#!/bin/sh\n" << does << "\n";
        fs::permissions(scratch / name, fs::perms::owner_all);
    };
    program("sbatch", "echo \"$@\" >>'" + (scratch / "asked").string() + "'\necho 7");  // accepts jobs, but does not run them yet
    program("squeue", "echo 7");
    const std::string run = (scratch / "run").string();
    const auto farm = [&] {
        return std::vector<std::string>{"-c", "PATH=" + scratch.path().string() + ":$PATH exec " WHORL_PROGRAM " farm " +
                                                  (scratch / "scene.toml").string() + " --on slurm --out " + run};
    };
    test::Program first(farm(), "bash");
    REQUIRE(first.wait_until([&] { return fs::exists(scratch / "run/farm/jobs.txt"); }));
    test::refusal(test::Program(farm(), "bash").wait());
    first.signal(SIGINT);
    CHECK(first.wait().code == 130);
    CHECK_THAT(read_whole(scratch / "asked"), Catch::Contains("--dependency=afterok:7 --kill-on-invalid-dep=yes"));
    const std::string second = test::refusal(test::Program(farm(), "bash").wait());
    CHECK(second.find("jobs of an earlier farm are at work in this folder: 7") != std::string::npos);
    CHECK(second.find("scancel 7") != std::string::npos);
    for (const char* how : {"", " --overwrite"}) {
        CHECK_THAT(test::refusal(test::Program({"-c", "PATH=" + scratch.path().string() + ":$PATH exec " WHORL_PROGRAM " render " +
                                                          (scratch / "scene.toml").string() + " --frames 1 --out " + run + how},
                                               "bash")
                                     .wait()),
                   Catch::Contains("jobs of an earlier farm"));
    }
    CHECK(
        test::Program({"-c", "PATH=" + scratch.path().string() + ":$PATH exec bash " + run + "/farm/simulate.sh 0"}, "bash").wait().code ==
        0);
    {  // A farm on this machine, between two of its jobs.
        program("squeue", "exit 1");
        const RunFolder held = RunFolder::any(scratch / "run/farm");
        CHECK_THAT(test::refusal(scratch.whorl({"farm"}, "run")), Catch::Contains("another run is at work"));
    }
}

}  // namespace farm_test

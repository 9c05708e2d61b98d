#include "tools/film/run_folder.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "engine/io/csv.h"
#include "tests/support/film_runs.h"
#include "tests/support/program.h"
#include "tests/support/scenes.h"

using namespace whorl;
using test::Outcome;
using test::Program;
namespace fs = std::filesystem;

namespace run_folder_test {

using test::files_in;
using Scratch = test::FilmScratch;

TEST_CASE("a run in the folder is replaced with --overwrite only, and other files stay", "[tools][render]") {
    const Scratch scratch;
    std::vector<std::string> arguments{"render", scratch.scene(), "--no-images", "--until", "0.03", "--out", scratch.run() + "/"};
    fs::create_directories(scratch / "run");
    std::ofstream(scratch / "run/thesis.txt") << "years of work";
    CHECK_THAT(test::refusal(arguments), Catch::Contains("contains files but no run"));
    CHECK(files_in(scratch / "run").size() == 1);

    fs::remove(scratch / "run/thesis.txt");
    test::succeed(arguments);
    for (const char* own : {"run/notes.txt", "run/talk.gif"}) std::ofstream(scratch / own) << "keep";
    const std::string first = read_whole(scratch / "run/log.txt");
    CHECK_THAT(test::refusal(arguments),
               Catch::Contains("the folder already contains a run; choose another folder with --out, or replace the run with"));
    CHECK(read_whole(scratch / "run/log.txt") == first);

    fs::create_directory_symlink(scratch / "run", scratch / "link");
    arguments.back() = (scratch / "link/").string();
    arguments.emplace_back("--overwrite");
    test::succeed(arguments);
    CHECK(fs::is_symlink(scratch / "link"));
    CHECK(read_whole(scratch / "run/log.txt") != first);
    for (const char* own : {"run/notes.txt", "run/talk.gif"}) CHECK(read_whole(scratch / own) == "keep");
    CHECK(test::whorl({"resume", (scratch / "nowhere").string()}).code == 2);
    CHECK_THAT(test::whorl({"resume", scratch.run() + "/scene.resolved.toml"}).err,
               Catch::EndsWith("is a file, not a folder; its run is " + scratch.run() + "; the folder of a run, as in out/honey_coil\n"));
    CHECK_THAT(test::whorl({"resume", scratch.scene()}).err,
               Catch::EndsWith("is a file, not a folder; the folder of a run, as in out/honey_coil\n"));
    CHECK_THAT(test::whorl({"render", scratch.scene(), "--out", ""}).err,
               Catch::Contains("--out: is empty; give a name, or remove the option"));
    CHECK(test::whorl({"video", scratch.run()}).code == 2);
}

TEST_CASE("without ffmpeg a video is refused before an earlier run is changed", "[tools][render]") {
    const Scratch scratch;
    scratch.render({"--frames", "2", "--size", "64x36"});
    const auto first = files_in(scratch / "run");
    const std::string video = read_whole(scratch / "run/little_honey.mp4");
    std::ofstream(scratch / "panels.toml") << test::honey << "[[panel]]\nset = [\"seed=1\"]\n[[panel]]\nset = [\"seed=2\"]\n";
    const std::string over_it = " --quiet --overwrite --out '" + scratch.run() + "' --frames 2 --size 96x54";
    const std::string no_video = ", or run with --no-video";
    for (const auto& [command, way_out] : std::vector<std::pair<std::string, std::string>>{
             {"render '" + scratch.scene() + "'" + over_it, no_video},
             {"render '" + (scratch / "panels.toml").string() + "'" + over_it, no_video},
             {"farm '" + scratch.scene() + "' --on local --overwrite --out '" + scratch.run() + "'", no_video},
             {"resume '" + scratch.run() + "' --frames 3", no_video},
             {"video '" + scratch.run() + "'", ""}}) {
        const Outcome no_encoder = Program({"-c", "PATH=/nowhere exec " WHORL_PROGRAM " " + command}, "bash").wait();
        INFO(command);
        CHECK(no_encoder.code == 1);
        CHECK_THAT(no_encoder.err, Catch::StartsWith("whorl: no video: cannot start ffmpeg: ") &&
                                       Catch::EndsWith("\n  remedy: apt-get install ffmpeg" + way_out + "\n"));
        CHECK(read_whole(scratch / "run/little_honey.mp4") == video);
        CHECK(files_in(scratch / "run").size() == first.size());
    }
}

TEST_CASE("every command leaves a folder unchanged while another process works in it", "[tools][render]") {
    const Scratch scratch;
    scratch.render({"--no-images", "--frames", "1"});
    const RunFolder held = RunFolder::existing(scratch.run());
    const std::string study = (scratch / "study.toml").string();
    std::ofstream(study) << "scenes = [\"scene.toml\"]\n[accuracy]\ncolumn = \"kinetic_energy\"\n[stability]\n[[knob]]\n"
                            "key = \"time.cfl\"\nvalues = [0.2, 0.4]\n";
    for (const std::vector<std::string>& words : {std::vector<std::string>{"video", scratch.run()},
                                                  {"video", scratch.run(), "--out", scratch.run("film.mp4")},
                                                  {"draw", scratch.run()},
                                                  {"resume", scratch.run()},
                                                  {"tradeoff", study, "--out", scratch.run()},
                                                  {"stability", study, "--out", scratch.run()}}) {
        const Outcome refused = test::whorl(words);
        INFO(words[0] << refused.err);
        CHECK(refused.code == 2);
        CHECK(refused.err.find("another run is at work in this folder; wait for it") != std::string::npos);
    }
}

}  // namespace run_folder_test

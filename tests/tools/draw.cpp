// Pictures drawn again from a run's frames.
#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/io/csv.h"
#include "render/image/image.h"
#include "tests/support/film_runs.h"
#include "tools/cost/choices.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/run.h"
#include "tools/film/run_folder.h"

using namespace whorl;
using test::Outcome;
namespace fs = std::filesystem;

namespace draw_test {

namespace {

const std::string puddle = "name = \"puddle\"\n" + test::falling_drop(20) + "size = [160, 90]\nexport = [\"raw\"]\nvideo = false\n";

struct Scratch : test::FilmScratch {
    explicit Scratch(const std::string& more = "") : FilmScratch(puddle + more) {}
};

}  // namespace

TEST_CASE("draw makes bit-identical images to render, and other images with another look") {
    const Scratch scratch;
    const fs::path run = scratch / "run", other = scratch / "other";
    scratch.render();
    const auto picture = [](const fs::path& of, int n) { return read_whole(of / "frames" / ("00000" + std::to_string(n) + ".png")); };
    const std::string first = picture(run, 1), third = picture(run, 3);
    fs::remove_all(run / "frames");
    test::succeed({"draw", scratch.run(), "--quiet"});
    CHECK(picture(run, 1) == first);
    CHECK(picture(run, 3) == third);

    test::succeed({"draw", scratch.run(), "--frames", "2-3", "--set", "look.style=particles", "--out", other.string(), "--quiet"});
    CHECK_FALSE(fs::exists(other / "frames/000001.png"));
    CHECK(picture(other, 3) != third);
}

TEST_CASE("draw gives solids another look, and refuses to show a solid that the run hid") {
    const Scratch scratch("[[solid]]\nshape = \"box\"\nmin = [-0.02, 0.0, -0.02]\nmax = [0.02, 0.004, 0.02]\n");
    const fs::path other = scratch / "other";
    scratch.render({"--frames", "1"});
    const auto drawn = [&](const std::string& change) {
        test::succeed({"draw", scratch.run(), "--set", change, "--out", other.string(), "--quiet", "--overwrite"});
        return read_whole(other / "frames/000001.png");
    };
    const std::string same = drawn("solid[1].material=ceramic");
    CHECK((same == read_whole(scratch / "run/frames/000001.png")));
    CHECK((drawn("solid[1].colour=#20a040") != same));
    CHECK_THAT(test::refusal({"draw", scratch.run(), "--set", "solid[1].show=false", "--out", other.string(), "--quiet", "--overwrite"}),
               Catch::Contains("--set solid[1].show=false: the change affects the simulation"));
}

TEST_CASE("drawing a range into its run keeps its exports, and elsewhere replaces another run") {
    const Scratch scratch;
    const fs::path run = scratch / "run", other = scratch / "other";
    scratch.render({"--export", "raw,scene,vtk,mesh"});
    const std::string glb = read_whole(run / "scene/puddle.glb"), pvd = read_whole(run / "vtk/puddle.pvd");
    const auto mesh = [&](int n) { return read_whole(run / "mesh" / ("puddle.000" + std::to_string(n) + ".ply")); };
    const std::string first = mesh(1), second = mesh(2);
    const Outcome range = test::whorl({"draw", scratch.run(), "--frames", "2-3", "--set", "surface.voxel=1"});
    CHECK_THAT(range.err, Catch::StartsWith("existing images in " + scratch.run() + " are replaced: 2\n"));
    CHECK((read_whole(run / "scene/puddle.glb") == glb));
    CHECK(read_whole(run / "vtk/puddle.pvd") == pvd);
    CHECK((mesh(1) == first));
    CHECK((mesh(2) != second));

    scratch.render({"--frames", "1"}, "other");
    for (const char* frames : {"1-2", "3"}) test::succeed({"draw", run, "--frames", frames, "--out", other, "--quiet", "--overwrite"});
    CHECK_FALSE(fs::exists(other / "diagnostics.csv"));
    CHECK(fs::exists(other / "frames/000001.png"));
    CHECK(fs::exists(other / "frames/000003.png"));
    test::succeed({"video", other.string()});
    CHECK_THAT(test::whorl({"resume", other.string()}).err, Catch::Contains("contains images that were drawn from another run; continue"));
    {
        const RunFolder held = RunFolder::existing(other);
        CHECK_THAT(test::refusal({"draw", scratch.run(), "--out", other.string()}),
                   Catch::Contains("another run is at work in this folder"));
    }
    fs::rename(run, scratch / "moved");
    CHECK_THAT(test::whorl({"resume", other.string()}).err, Catch::Contains("another run; that run is no longer in "));
    fs::rename(scratch / "moved", run);
    for (const char* file : {"run.json", "scene.resolved.toml"}) fs::remove(other / file);
    std::ofstream(other / "thesis.txt") << "years of work";
    CHECK(test::whorl({"draw", scratch.run(), "--frames", "2", "--out", other.string(), "--quiet"}).code == 2);
}

TEST_CASE("images of a run that was replaced are replaced with --overwrite only") {
    const Scratch scratch;
    const fs::path run = scratch / "run", drawn = scratch / "drawn";
    std::vector<std::string> draw{"draw", scratch.run(), "--out", drawn.string(), "--quiet"};
    scratch.render({"--frames", "2", "--no-draw"});
    test::succeed(draw);
    test::succeed({"resume", scratch.run(), "--frames", "3", "--no-draw", "--quiet"});
    CHECK(test::succeed(draw).err == "");  // the same run, extended
    scratch.render({"--frames", "1", "--no-draw", "--overwrite"});
    CHECK_THAT(test::refusal(draw), Catch::Contains(drawn.string() + ": the folder already contains a run"));
    draw.emplace_back("--overwrite");
    test::succeed(draw);
    CHECK_FALSE(fs::exists(drawn / "frames/000003.png"));
}

TEST_CASE("a run with gaps gets its video and contact sheet, and existing files are reported") {
    const Scratch scratch;
    const fs::path run = scratch / "run";
    scratch.render({"--no-draw"});
    test::succeed({"draw", scratch.run(), "--frames", "2-3", "--quiet"});
    test::succeed({"video", scratch.run(), "--fps", "1e-4"});
    CHECK(fs::exists(run / "contact.png"));
    fs::remove(run / "raw/000001.frame");
    test::succeed({"draw", scratch.run(), "--quiet"});
    CHECK_THAT(test::whorl({"draw", scratch.run(), "--frames", "1"}).err, Catch::EndsWith("missing frames 1 to 1; 2 to 3\n"));
    const std::string nowhere = (scratch / "none/a.mp4").string();
    for (const auto& [option, value, why] : std::vector<std::array<std::string, 3>>{
             {"--out", nowhere, "--out: folder not found: \"" + (scratch / "none").string() + "\"; create it first"},
             {"--fps", "1e-9", "--fps: 1e-09 frames per second are too few for a video; allowed: at least 0.0001"}})
        CHECK_THAT(test::refusal({"video", scratch.run(), option, value}), Catch::Contains(why));
}

TEST_CASE("ranges that a new look leaves open use the whole run, whichever frames are drawn") {
    const Scratch scratch("[camera]\nkind = \"fixed\"\nposition = [0, 0.02, 0.1]\ntarget = [0, 0.02, 0]\n");
    const fs::path run = scratch / "run";
    scratch.render({"--no-images"});
    const std::vector<std::string> look{"look.style=particles", "look.field=speed", "camera.kind=auto"};
    const SceneFile file = read_scene_file(run / "scene.resolved.toml", look);
    const std::vector<int> frames = exported_frames(run);
    REQUIRE(frames.size() == 3);
    const SceneFile chosen = with_choices_from(file, run, frames);
    // It falls for .1 s and then lands, at about 1 m/s from rest. It is 24 mm thick and falls by 8 mm.
    CHECK(chosen.look.range[0] == 0);
    CHECK(chosen.look.range[1] >= 0.4f);
    CHECK(chosen.look.range[1] <= 1.2f);
    REQUIRE(chosen.camera.max.has_value());
    CHECK((*chosen.camera.max - *chosen.camera.min).maxCoeff() < 0.045f);

    const auto draw = [&](const std::string& out, const std::vector<std::string>& set, const std::vector<std::string>& more) {
        std::vector<std::string> words{"draw", scratch.run(), "--quiet", "--out", (scratch / out).string()};
        for (const std::string& s : set) words.insert(words.end(), {"--set", s});
        words.insert(words.end(), more.begin(), more.end());
        test::succeed(words);
        return read_whole(scratch / out / "frames/000002.png");
    };
    const auto list = [](std::initializer_list<float> numbers) {
        std::string text;
        for (const float x : numbers) text += (text.empty() ? "[" : ", ") + std::to_string(x);
        return text + "]";
    };
    const Vec3f low = *chosen.camera.min, high = *chosen.camera.max;
    std::vector<std::string> given = look;
    given.push_back("look.range=" + list({chosen.look.range[0], chosen.look.range[1]}));
    given.push_back("camera.min=" + list({low.x(), low.y(), low.z()}));
    given.push_back("camera.max=" + list({high.x(), high.y(), high.z()}));
    const std::string one = draw("one", look, {"--frames", "2"});
    CHECK((one == draw("all", look, {})));
    CHECK((one == draw("given", given, {})));
}

TEST_CASE("draw follows a running render, next to its images, or in its folder if it makes none") {
    const Scratch scratch;
    const fs::path run = scratch / "run", other = scratch / "other";
    const bool draws_itself = GENERATE(true, false);
    std::vector<std::string> words{"render", scratch.scene(),      "--out", scratch.run(),         "--quiet", "--set", "time.fps=50",
                                   "--set",  "fluid.spacing=2e-3", "--set", "output.size=[64, 36]"};
    if (!draws_itself) words.emplace_back("--no-draw");
    test::Program program(words);
    REQUIRE(program.wait_until([&] { return fs::exists(run / "raw/000001.frame"); }));
    program.signal(SIGSTOP);  // slow enough to be still running
    std::vector<std::string> draw{"draw", scratch.run(), "--quiet", "--set", "look.style=particles"};
    if (draws_itself) {
        CHECK_THAT(test::refusal(draw),
                   Catch::Contains("the run is in progress and draws its own images here; draw into another folder, as in --out " +
                                   scratch.run() + "_drawn"));
        draw.insert(draw.end(), {"--out", other.string()});
    }
    const fs::path drawn = draws_itself ? other : run;
    test::Program follower(draw);
    REQUIRE(follower.wait_until([&] { return fs::exists(drawn / "frames/000001.png"); }));
    if (!draws_itself) CHECK_THAT(test::whorl(draw).err, Catch::Contains("another run is at work in this folder"));
    program.signal(SIGCONT);
    CHECK(program.wait().code == 0);
    CHECK_THAT(test::succeed(follower.wait()).err, Catch::Contains("the run continues: its frames are drawn as they come, until it ends"));
    const std::vector<int> frames = exported_frames(run);
    CHECK(frames.size() == 6);
    for (const int n : frames) CHECK(has_picture(drawn, n));
    CHECK(fs::exists(drawn / "contact.png"));
}

TEST_CASE("draw warns of a camera that shows nothing") {
    const Scratch scratch;
    const fs::path run = scratch / "run";
    scratch.render({"--frames", "1"});
    CHECK_THAT(test::succeed({"draw", scratch.run(), "--set", "camera.kind=fixed", "--set", "camera.position=[0, 0.02, 0.1]", "--set",
                              "camera.target=[0, 0.02, 3]"})
                   .err,
               Catch::Contains("warning: camera: from"));
}

TEST_CASE("draw refuses frames that it cannot draw, and changes nothing") {
    const Scratch scratch;
    const fs::path run = scratch / "run";
    scratch.render({"--frames", "2"});
    const auto refused = [&](const std::vector<std::string>& more, const std::string& why) {
        std::vector<std::string> words{"draw", scratch.run(), "--quiet"};
        words.insert(words.end(), more.begin(), more.end());
        CHECK_THAT(test::refusal(words), Catch::Contains(why));
    };
    refused({"--set", "look.exposure=2", "--set", "fluid.viscosity=3"}, "--set fluid.viscosity=3: the change affects the simulation");
    refused({"--set", "look.foam=1"}, "look.foam: the frames of the run have no foam; render the scene again with look.foam");
    refused({"--frames", "2", "--size", "320x180"}, "--frames: the other images in " + scratch.run() +
                                                        " are 160x90, but the new ones would be 320x180; draw all frames, or choose");
    CHECK_THAT(test::whorl({"draw", scratch.run(), "--frames", "2"}).err,
               Catch::Contains("CPU seconds per frame: draw ") && Catch::Contains("1 frame drawn: "));
    CHECK(test::whorl({"video", scratch.run(), "--out", (scratch / "a.mp4").string()}).err == "");
    fs::rename(run / "frames/000002.png", scratch / "second.png");
    CHECK(test::succeed({"video", scratch.run(), "--out", (scratch / "a.mp4").string()}).err ==
          "the run has images of 1 of its 2 frames; the video contains only these\n");
    refused({"--frames", "3-4"}, "missing frames 3 to 4; 1 to 2");
    for (const char* frames : {"two", "1-", "-1", "2-1", "99999999999", "1-99999999999"})
        refused({"--frames", frames}, "is not a frame or a range of frames");
    fs::rename(run / "raw/000002.frame", run / "raw/000003.frame");
    fs::copy(run / "raw/000001.frame", run / "raw/000002.frame");
    refused({}, "000002.frame: contains frame 1, not 2");
    fs::rename(run / "raw/000003.frame", run / "raw/000002.frame");
    std::ofstream(run / "raw/000002.frame", std::ios::app) << "x";
    refused({}, "000002.frame: is not a complete frame");
    fs::remove_all(run / "raw");
    refused({}, "render the scene with --export raw");
}

TEST_CASE("a run with images of another size does not continue, and the error names the image") {
    const Scratch scratch;
    const fs::path run = scratch / "run";
    scratch.render({"--frames", "1", "--set", "output.video=true"});
    test::succeed({"draw", scratch.run(), "--size", "320x180", "--quiet"});
    CHECK_THAT(test::refusal({"resume", scratch.run(), "--frames", "3", "--quiet"}),
               Catch::Contains("frames/000001.png: is 320x180, but the video is 160x90; draw raw frames again: whorl draw"));
    test::succeed({"draw", scratch.run(), "--quiet"});
    test::succeed({"resume", scratch.run(), "--frames", "3", "--quiet"});
    CHECK(fs::exists(run / "puddle.mp4"));
}

TEST_CASE("images of one pixel make no video") {
    const test::ScratchFolder scratch;
    std::ofstream(scratch / "scene.resolved.toml") << puddle;
    fs::create_directories(scratch / "frames");
    write_png(scratch / "frames/000001.png", plain_image(1, 1, 0));
    CHECK_THAT(test::refusal({"video", scratch.path().string()}), Catch::Contains("000001.png: is 1x1; a video needs at least 2x2 pixels"));
}

}  // namespace draw_test

// Several runs of one scene side by side in one film.
#include <signal.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/io/csv.h"
#include "render/image/image.h"
#include "tests/support/film_runs.h"
#include "tests/support/scene_text.h"
#include "tools/film/panel_scenes.h"
#include "tools/film/run.h"

using namespace whorl;
using test::Outcome;
using test::Program;
using test::report;
namespace fs = std::filesystem;

namespace panels_test {

namespace {

/// 26 lines.
const std::string drop = "name = \"two_drops\"\n" + test::falling_drop(40) + R"(size = [164, 90]
[[panel]]
label = "water"
[[panel]]
label = "syrup"
set = ["fluid.viscosity=50", "look.material=chocolate"]
)";

struct Scratch : test::FilmScratch {
    explicit Scratch(const std::string& text = drop) : FilmScratch(text) {}
};

}  // namespace

TEST_CASE("panels of a 2D flow are arranged so that the flow is largest") {
    Scene scene;
    scene.domain.dimensions = 2;
    scene.panels.resize(2);
    scene.output.size = {1280, 720};
    scene.domain.min = Vec3d::Zero();
    for (const auto& [width, height, columns] : std::vector<std::array<int, 3>>{{4, 1, 1}, {2, 1, 1}, {1, 1, 2}, {1, 3, 2}}) {
        scene.domain.max = Vec3d(width, height, 0);
        INFO(width << " : " << height);
        CHECK(panel_columns(scene) == columns);
    }
}

TEST_CASE("a panel's label is the title of its images unless it has a title") {
    const Scratch scratch(drop + "[[panel]]\nlabel = \"third\"\nset = [\"look.title=mine\"]\n");
    const std::vector<SceneFile> panels = panel_scenes(read_scene_file(scratch.scene()));
    REQUIRE(panels.size() == 3);
    CHECK(panels[0].look.title == "water");
    CHECK(panels[2].look.title == "mine");
}

TEST_CASE("a scene may set keys that only a panel's style or model uses") {
    const Scratch scratch(drop + "set = [\"models.micropolar=notes\", \"look.style=opaque\"]\n[micropolar]\n" +
                          "transfer_viscosity = 0.5\n[look]\ncolour = \"#ff0080\"\n");
    std::string text = read_whole(scratch.scene());
    text.erase(text.find("set = "), text.find('\n', text.find("set = ")) - text.find("set = "));
    std::ofstream(scratch.scene()) << text;
    const std::vector<SceneFile> panels = panel_scenes(read_scene_file(scratch.scene()));
    CHECK(panels[1].scene.micropolar.transfer_viscosity == 0.5);
    CHECK((panels[1].look.colour - Vec3f(1, 0, 0.21586f)).norm() < 1e-5f);  // 128/255 of sRGB in linear light
}

TEST_CASE("two or three panels are in a row, more in a square, or as the scene specifies") {
    Scene scene;
    const auto columns = [&](std::size_t panels) {
        scene.panels.resize(panels);
        return panel_columns(scene);
    };
    CHECK(columns(1) == 1);
    CHECK(columns(2) == 2);
    CHECK(columns(3) == 3);
    CHECK(columns(4) == 2);
    CHECK(columns(5) == 3);
    scene.output.panel_columns = 1;
    CHECK(columns(2) == 1);
    scene.output.panel_columns = 9;
    CHECK(columns(2) == 2);
}

TEST_CASE("panels that show the same field share the range of the colour map") {
    const Scratch scratch(drop + "[[panel]]\nset = [\"domain.gravity=[0, -40, 0]\"]\n");
    Options options;
    options.scene = scratch.scene();
    options.set = {"look.style=particles", "look.field=speed", "models.viscosity=none"};
    const auto scenes = panel_scenes(read_scene_file(options));
    REQUIRE(scenes.size() == 3);
    CHECK(scenes[0].look.range[1] > 0);
    CHECK(scenes[0].look.range == scenes[2].look.range);
    CHECK(scenes[1].scene.fluid.viscosity(0, 0, 0) == 50);
    // Three in a row of 164 pixels, 4 apart: even widths.
    CHECK(scenes[0].scene.output.size == std::array<int, 2>{52, 90});
}

TEST_CASE("a scene with panels makes one video of complete runs side by side") {
    const Scratch scratch;
    scratch.render();
    const fs::path run = scratch.run();
    CHECK(fs::exists(run / "two_drops.mp4"));
    CHECK(fs::exists(run / "contact.png"));
    CHECK(report(run).at("status") == "done");
    CHECK(report(run).at("panels").size() == 2);
    CHECK(report(run).at("frames") == 5);
    for (const char* panel : {"1", "2"}) {
        CHECK(fs::exists(run / "panels" / panel / "diagnostics.csv"));
        CHECK(report(run / "panels" / panel).at("frames") == 5);
    }
    const Image whole = read_png(run / "frames/000005.png"), left = read_png(run / "panels/1/frames/000005.png");
    CHECK(whole.width == 164);
    CHECK(left.width == 80);
    // Below the label, the left half is the first panel.
    CHECK(std::equal(left.pixel(0, 60), left.pixel(0, 61), whole.pixel(0, 60)));
    // A second render starts with an empty folder.
    CHECK_THAT(test::succeed({"render", scratch.scene(), "--out", scratch.run(), "--overwrite", "--frames", "2"}).err,
               Catch::Contains("2 frames of 2 panels: " + scratch.run() + "/two_drops.mp4"));
    CHECK(report(run).at("frames") == 2);
    CHECK_FALSE(fs::exists(run / "frames/000003.png"));
}

TEST_CASE("interrupted panels continue to the same film") {
    const Scratch scratch;
    scratch.render({"--no-video"}, "whole");
    Program program({"render", scratch.scene(), "--out", scratch.run("parts"), "--no-video", "--quiet"});
    const fs::path parts = scratch.run("parts");
    REQUIRE(program.wait_until([&] { return fs::exists(parts / "panels/2/frames/000002.png"); }));
    program.signal(SIGINT);
    const Outcome stopped = program.wait();
    // A fast machine may finish before the signal.
    if (stopped.code != 0) {
        CHECK(stopped.code == 130);
        CHECK(stopped.err.find("whorl resume " + parts.string()) != std::string::npos);
        CHECK(report(parts).at("status") == "interrupted");
        test::succeed({"resume", parts.string(), "--quiet"});
    }
    CHECK(report(parts).at("status") == "done");
    CHECK(difference(read_png(parts / "frames/000005.png"), read_png(scratch / "whole" / "frames/000005.png")).max < 1);
}

TEST_CASE("an extended run of panels keeps its first colours, and its settings repeat it") {
    // The range of the speed depends on the whole run, so a longer run would have another range.
    const Scratch scratch;
    scratch.render({"--until", "0.05", "--set", "look.style=particles", "--set", "look.field=speed", "--no-video"});
    const fs::path run = scratch.run();
    const std::string second = read_whole(run / "frames/000002.png");
    test::succeed({"resume", scratch.run(), "--until", "0.1", "--quiet"});
    CHECK(report(run).at("frames") == 5);
    CHECK((read_whole(run / "frames/000002.png") == second));
    test::succeed({"render", (run / "scene.resolved.toml").string(), "--quiet", "--out", scratch.run("again")});
    for (const char* picture : {"frames/000002.png", "frames/000005.png"})
        CHECK(difference(read_png(run / picture), read_png(scratch / "again" / picture)).max < 1);
    const std::string settings = read_whole(run / "scene.resolved.toml");
    CHECK_THAT(test::refusal({"resume", scratch.run(), "--until", "0.05", "--quiet"}),
               Catch::Contains("the run has already reached frame 5 (0.1 s)"));
    CHECK((read_whole(run / "scene.resolved.toml") == settings));
}

TEST_CASE("a run of panels stays unchanged if one cannot be extended or has no valid checkpoint") {
    // Ten times the largest speed that the plan sees until the end: the jet of the second panel gets faster.
    std::string text = drop;
    text.replace(text.find("[output]"), 0, "[[emitter]]\nposition = [0, 0.05, 0]\nradius = 5e-3\nspeed = \"0.3\"\n");
    text.replace(text.find("set = ["), text.size(), "set = ['emitter[0].speed=\"0.3+40*t\"']\n");
    text.replace(text.find("\"ppe\""), 5, "\"wcsph\"");
    const Scratch scratch(text);
    scratch.render({"--no-images", "--until", "0.03"});
    const fs::path run = scratch.run();
    const auto states = [&] {
        return read_whole(run / "scene.resolved.toml") + read_whole(run / "run.json") + read_whole(run / "panels/1/run.json");
    };
    const std::string before = states();
    CHECK_THAT(test::refusal({"resume", scratch.run(), "--until", "0.1", "--quiet"}), Catch::Contains("pressure.sound_speed"));
    CHECK((states() == before));
    test::succeed({"resume", scratch.run(), "--quiet"});
    for (const auto& entry : fs::directory_iterator(run / "panels/2/checkpoints")) fs::resize_file(entry.path(), 100);
    CHECK_THAT(test::refusal({"resume", scratch.run(), "--until", "0.05", "--quiet"}),
               Catch::Contains(".whorl is damaged") && Catch::Contains("panels/2: no valid checkpoint to continue from"));
    CHECK(report(run / "panels/1").at("frames") == 2);
}

TEST_CASE("warnings of panels name their runs, and are printed once if all panels have them") {
    const auto warnings = [](const std::string& set, const std::string& other) {
        const Scratch scratch(drop + "[[panel]]\nset = [\"fluid.density=" + other + "\"]\n");
        Options options;
        options.scene = scratch.scene(), options.set = {"fluid.density=" + set};
        SceneFile file = read_scene_file(options);
        file.scene.panels.erase(file.scene.panels.begin());
        file.scene.panels[0].set = {"fluid.density=" + (set == "40000" ? other : set)};
        return warnings_of(file);
    };
    CHECK(warnings("40000", "1000").empty());
    REQUIRE(warnings("1000", "40000").size() == 1);
    CHECK_THAT(warnings("1000", "40000")[0], Catch::StartsWith("panel 2: fluid.density = 40000"));
    REQUIRE(warnings("40000", "40000").size() == 1);
    CHECK_THAT(warnings("40000", "40000")[0], Catch::StartsWith("fluid.density = 40000"));
}

TEST_CASE("a panel's wrong key is reported with its location, before anything is written") {
    const Scratch scratch(drop + "[[panel]]\nset = [\"fluid.viscocity=3\"]\n");
    CHECK_THAT(test::refusal({"render", scratch.scene(), "--out", scratch.run(), "--quiet"}),
               Catch::Contains("scene.toml:28:7: panel[2].set: unknown key \"fluid.viscocity\"; did you mean \"fluid.viscosity\"?"));
    CHECK_FALSE(fs::exists(scratch.run()));
}

TEST_CASE("a panel with images of another size, or without images, is refused before the run") {
    const auto refused = [](const std::string& set, const std::string& why) {
        const Scratch scratch(drop + "[[panel]]\nset = [\"" + set + "\"]\n");
        CHECK_THAT(test::refusal({"render", scratch.scene(), "--out", scratch.run(), "--quiet"}),
                   Catch::Contains("scene.toml:28:7: panel[2].set: " + why));
        CHECK_FALSE(fs::exists(scratch.run()));
    };
    refused("output.size=[1280, 720]", "all panels have the same size");
    refused("output.images=false", "a panel without images leaves its part of the video empty");
}

TEST_CASE("panels are combined when the images of each are drawn") {
    const Scratch scratch;
    scratch.render({"--until", "0.05", "--no-video"}, "whole");
    scratch.render({"--until", "0.05", "--no-draw"});
    const fs::path run = scratch.run();
    CHECK_FALSE(fs::exists(run / "two_drops.mp4"));
    CHECK_FALSE(fs::exists(run / "panels/1/frames/000001.png"));
    CHECK_THAT(test::whorl({"draw", scratch.run()}).err, Catch::Contains("then combine them: whorl resume " + scratch.run() + "\n"));
    CHECK_THAT(test::whorl({"resume", scratch.run()}).err,
               Catch::Contains("panels/1: the run has no image of frame 1; draw it first: whorl draw " + scratch.run() + "/panels/1"));
    const auto draw = [&](const std::string& panel, const std::string& size) {
        test::succeed({"draw", run / "panels" / panel, "--size", size, "--quiet"});
    };
    draw("1", "80x90"), draw("2", "64x36");
    CHECK_THAT(test::whorl({"resume", scratch.run()}).err, Catch::Contains("panels/2/frames/000001.png: is 64x36, but the video is 80x90"));
    draw("2", "80x90");
    CHECK(test::succeed({"resume", scratch.run(), "--quiet"}).err == "");
    CHECK(fs::exists(run / "two_drops.mp4"));
    CHECK((read_whole(run / "frames/000003.png") == read_whole(scratch / "whole" / "frames/000003.png")));
}

namespace {

/// A plane that turns, in one panel twice as fast.
const std::string turning = "name = \"turning\"\n" + test::text::time(0.02, "fps = 100") +
                            test::text::domain({0, 0}, {0.1, 0.1}, "periodic = [true, true]\ngravity = [0, 0]") +
                            test::text::fluid(5e-3, 1e-3) +
                            test::text::block({0, 0}, {0.1, 0.1}, "velocity = [\"0.1*sin(20*pi*y)\", \"0\"]") + R"toml([[probe]]
name = "flow"
kind = "flow"
min = [0, 0]
max = [0.1, 0.1]
[look]
style = "slice"
field = "vorticity"
colour_map = "coolwarm"
streaks = false
background = "white"
[output]
size = [640, 360]
video = false
chart = "flow.kinetic_energy"
[[panel]]
label = "slow"
[[panel]]
label = "fast"
set = ['block[0].velocity=["0.2*sin(20*pi*y)", "0"]']
[[panel]]
difference = ["slow", "fast"]
)toml";

}  // namespace

TEST_CASE("a third panel shows the difference of two runs, and a chart below a probe of both") {
    const Scratch scratch(turning);
    scratch.render();
    const fs::path run = scratch.run();
    CHECK(report(run).at("panels").size() == 2);
    CHECK_FALSE(fs::exists(run / "panels/1/raw"));  // not requested
    const Image whole = read_png(run / "frames/000003.png");
    CHECK(whole.width == 640);
    CHECK(whole.height == 360);
    const Image fast = read_png(run / "panels/2/frames/000001.png"), less = read_png(run / "panels/difference-3/frames/000001.png");
    REQUIRE(less.width == fast.width);
    // The difference has stripes of both signs.
    const auto blue_over_red = [](const Image& image, double height) {
        const std::uint8_t* p = image.pixel(image.width / 2, static_cast<int>(height * image.height));
        return static_cast<int>(p[2]) - static_cast<int>(p[0]);
    };
    int most = 0, least = 0;
    for (double h = 0.1; h < 0.9; h += 0.01) most = std::max(most, blue_over_red(less, h)), least = std::min(least, blue_over_red(less, h));
    CHECK(most > 100);
    CHECK(least < -100);
    // Chart and difference are made again from the existing files, with equal results.
    test::succeed({"resume", scratch.run(), "--quiet"});
    CHECK(difference(read_png(run / "frames/000003.png"), whole).max == 0);
}

TEST_CASE("an extended film with a difference equals a new film of its settings") {
    const Scratch scratch(turning);
    scratch.render({"--until", "0.01"});
    const fs::path run = scratch.run();
    REQUIRE_FALSE(fs::exists(run / "panels/1/raw"));
    CHECK_THAT(test::succeed({"resume", scratch.run(), "--until", "0.03"}).err,
               Catch::Contains("panel 1 of 2: slow, from the start: a difference needs all frames"));
    CHECK(report(run).at("frames") == 4);
    CHECK_FALSE(fs::exists(run / "panels/1/raw"));
    test::succeed({"render", (run / "scene.resolved.toml").string(), "--quiet", "--out", scratch.run("again")});
    for (const char* picture : {"frames/000001.png", "frames/000004.png"})
        CHECK((read_whole(run / picture) == read_whole(scratch / "again" / picture)));
    // If frames are kept, the panels continue from their end.
    scratch.render({"--until", "0.01", "--export", "raw"}, "kept");
    CHECK_THAT(test::succeed({"resume", scratch.run("kept"), "--until", "0.03"}).err, !Catch::Contains("from the start"));
    CHECK((read_whole(scratch / "kept" / "frames/000004.png") == read_whole(run / "frames/000004.png")));
}

TEST_CASE("a difference or chart of a missing panel is refused with its location") {
    const auto refused = [](const std::string& from, const std::string& to, const std::string& why) {
        std::string text = turning;
        text.replace(text.find(from), from.size(), to);
        const Scratch scratch(text);
        CHECK_THAT(test::refusal({"render", scratch.scene(), "--out", scratch.run(), "--quiet"}),
                   Catch::Contains(why) && Catch::Contains("scene.toml:"));
        CHECK_FALSE(fs::exists(scratch.run()));
    };
    refused("[\"slow\", \"fast\"]", "[\"slow\", \"fats\"]", "has the label \"fats\"; did you mean \"fast\"?");
    refused("[\"slow\", \"fast\"]", "[\"slow\"]", "two labels, as in");
    refused("flow.kinetic_energy", "flow.kinetic_enrgy", "did you mean \"flow.kinetic_energy\"?");
    refused("style = \"slice\"\nfield = \"vorticity\"\ncolour_map = \"coolwarm\"\nstreaks = false", "style = \"particles\"",
            "a difference needs slices");
}

TEST_CASE("a film without a range uses the 99th percentile of a coarse run") {
    // u = .1 sin(20 pi y) m/s: the speed is at most .1, a little more as coarse particles settle, and the next round number is .12.
    std::string text = turning;
    text.erase(text.find("[[panel]]"));
    const Scratch scratch(text.replace(text.find("chart = \"flow.kinetic_energy\"\n"), 30, ""));
    CHECK_THAT(
        test::succeed({"render", scratch.scene(), "--out", scratch.run(), "--set", "look.field=speed", "--set", "look.colour_map=viridis"})
            .err,
        Catch::Contains("coarse run of the whole film"));
    const SceneFile used = read_scene_file(fs::path(scratch.run()) / "scene.resolved.toml");
    CHECK(used.look.range[0] == 0);
    CHECK(used.look.range[1] >= 0.1f);
    CHECK(used.look.range[1] < 0.13f);
}

}  // namespace panels_test

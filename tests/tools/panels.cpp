// Several runs of one scene side by side in one film.
#include "tools/film/panels.h"

#include <signal.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/io/files.h"
#include "render/image/difference.h"
#include "render/image/image.h"
#include "tests/support/program.h"
#include "tests/support/scratch.h"
#include "tools/film/panel_scenes.h"

using namespace whorl;
using test::Outcome;
using test::Program;
namespace fs = std::filesystem;

namespace panels_test {

namespace {

const char* const drop = R"(
name = "two_drops"
[time]
end = 0.1
fps = 40
[domain]
min = [-0.03, -0.01, -0.03]
max = [0.03, 0.06, 0.03]
[fluid]
spacing = 4e-3
viscosity = 1
[models]
pressure = "ppe"
[[block]]
shape = "sphere"
position = [0, 0.02, 0]
radius = 0.012
[[solid]]
shape = "plane"
[output]
size = [324, 180]
[[panel]]
label = "water"
[[panel]]
label = "syrup"
set = ["fluid.viscosity=50", "look.material=chocolate"]
)";

struct Scratch : test::ScratchFolder {
    explicit Scratch(const std::string& text = drop) { std::ofstream(*this / "scene.toml") << text; }
    std::string scene() const { return (*this / "scene.toml").string(); }
    std::string run(const std::string& name = "run") const { return (*this / name).string(); }
};

nlohmann::json run_json(const fs::path& folder) { return nlohmann::json::parse(read_whole(folder / "run.json")); }

}  // namespace

TEST_CASE("panels of a flow in the plane stand so that the flow is largest") {
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

TEST_CASE("a panel's label is the title of its pictures, unless it has one of its own") {
    const Scratch scratch(std::string(drop) + "[[panel]]\nlabel = \"third\"\nset = [\"look.title=mine\"]\n");
    const std::vector<SceneFile> panels = panel_scenes(read_scene_file(scratch.scene()));
    REQUIRE(panels.size() == 3);
    CHECK(panels[0].look.title == "water");
    CHECK(panels[2].look.title == "mine");
}

TEST_CASE("panels stand in a row of two or three, more of them in a square, or as the scene says") {
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
    const Scratch scratch(std::string(drop) + "[[panel]]\nset = [\"domain.gravity=[0, -40, 0]\"]\n");
    Options options;
    options.scene = scratch.scene();
    options.set = {"look.style=particles", "look.field=speed", "models.viscosity=none"};
    const auto scenes = panel_scenes(read_scene_file(options));
    REQUIRE(scenes.size() == 3);
    CHECK(scenes[0].look.range[1] > 0);
    CHECK(scenes[0].look.range == scenes[2].look.range);
    CHECK(scenes[1].scene.fluid.viscosity(0, 0, 0) == 50);
    // Three in a row of 324 pixels, 4 apart: even widths.
    CHECK(scenes[0].scene.output.size == std::array<int, 2>{104, 180});
}

TEST_CASE("a scene with panels is one film of runs side by side, each whole in itself") {
    const Scratch scratch;
    const Outcome outcome = test::whorl({"render", scratch.scene(), "--out", scratch.run(), "--quiet"});
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
    const fs::path run = scratch.run();
    CHECK(fs::exists(run / "two_drops.mp4"));
    CHECK(fs::exists(run / "contact.png"));
    CHECK(run_json(run).at("status") == "done");
    CHECK(run_json(run).at("panels").size() == 2);
    CHECK(run_json(run).at("frames") == 5);
    for (const char* panel : {"1", "2"}) {
        CHECK(fs::exists(run / "panels" / panel / "diagnostics.csv"));
        CHECK(run_json(run / "panels" / panel).at("frames") == 5);
    }
    const Image whole = read_png(run / "frames/000005.png"), left = read_png(run / "panels/1/frames/000005.png");
    CHECK(whole.width == 324);
    CHECK(left.width == 160);
    // Below the label, the left half is the first panel.
    CHECK(std::equal(left.pixel(0, 100), left.pixel(0, 101), whole.pixel(0, 100)));
    // Rendered again the folder begins anew.
    CHECK(test::whorl({"render", scratch.scene(), "--out", scratch.run(), "--quiet", "--frames", "2"}).code == 0);
    CHECK(run_json(run).at("frames") == 2);
    CHECK_FALSE(fs::exists(run / "frames/000003.png"));
}

TEST_CASE("panels that were interrupted go on to the same film") {
    const Scratch scratch;
    REQUIRE(test::whorl({"render", scratch.scene(), "--out", scratch.run("whole"), "--no-video", "--quiet"}).code == 0);
    Program program({"render", scratch.scene(), "--out", scratch.run("parts"), "--no-video", "--quiet"});
    const fs::path parts = scratch.run("parts");
    REQUIRE(program.wait_until([&] { return fs::exists(parts / "panels/2/frames/000002.png"); }));
    program.signal(SIGINT);
    const Outcome stopped = program.wait();
    // A quick machine may have finished before the signal.
    if (stopped.code != 0) {
        CHECK(stopped.code == 130);
        CHECK(stopped.err.find("whorl resume " + parts.string()) != std::string::npos);
        CHECK(run_json(parts).at("status") == "interrupted");
        REQUIRE(test::whorl({"resume", parts.string(), "--quiet"}).code == 0);
    }
    CHECK(run_json(parts).at("status") == "done");
    CHECK(difference(read_png(parts / "frames/000005.png"), read_png(fs::path(scratch.run("whole")) / "frames/000005.png")).max < 1);
}

TEST_CASE("a panel's wrong key is told with its place, before anything is written") {
    const Scratch scratch(std::string(drop) + "[[panel]]\nset = [\"fluid.viscocity=3\"]\n");
    const Outcome outcome = test::whorl({"render", scratch.scene(), "--out", scratch.run(), "--quiet"});
    CHECK(outcome.code == 2);
    CHECK(outcome.err.find("scene.toml:28:7: panel[2].set: unknown key \"fluid.viscocity\"; did you mean \"fluid.viscosity\"?") !=
          std::string::npos);
    CHECK_FALSE(fs::exists(scratch.run()));
}

}  // namespace panels_test

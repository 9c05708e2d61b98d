// Files that a scene names: meshes and the picture round it.
#include <catch2/catch.hpp>
#include <fstream>

#include "engine/io/csv.h"
#include "render/image/exr.h"
#include "tests/support/program.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"
#include "tools/film/panel_scenes.h"
#include "tools/live/controls.h"
#include "tools/scene_file/scene_changes.h"

using namespace whorl;
namespace fs = std::filesystem;

namespace scene_files_test {

namespace {

const char* const tetrahedron = "v 0 0 0\nv .01 0 0\nv 0 .01 0\nv 0 0 .01\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// scenes/scene.toml with a mesh and a picture in its folder; tests run in another folder.
struct Scratch : test::ScratchFolder {
    explicit Scratch(const std::string& more, const std::string& before = "") {
        fs::create_directories(scenes());
        std::ofstream(scenes() / "one.obj") << tetrahedron;
        std::ofstream(scenes() / "other.obj") << tetrahedron;
        write_exr(scenes() / "room.exr", {1, 1, {1, 1, 1, 1}}, {});
        std::ofstream(scene()) << before + test::little_honey("end = 1", 4e-3, std::string(test::lump_and_thread) + more);
    }
    fs::path scenes() const { return *this / "scenes"; }
    fs::path scene() const { return scenes() / "scene.toml"; }
};

const char* const mesh = "[[solid]]\nshape = \"mesh\"\nfile = \"one.obj\"\n";

std::string recorded(const Scratch& scratch) {
    Options options;
    options.scene = scratch.scene().string();
    ChangeRecording recording(scratch / "run");
    fs::create_directories(recording.folder());
    recording.begin(read_scene_file(options), scratch.scene(), "draft");
    recording.add(0.2, {{"fluid.viscosity", Value(77.0)}});
    recording.write(0.5);
    return recording.file().string();
}

}  // namespace

TEST_CASE("the recording of a live run finds the scene's files in another folder", "[tools][live]") {
    const Scratch scratch(std::string(mesh) + "[look]\nenvironment = \"room.exr\"\n");
    const SceneFile again = read_scene_file(recorded(scratch));
    CHECK(again.scene.solids.at(0).shape.file == scratch.scenes() / "one.obj");
    CHECK(again.look.environment == scratch.scenes() / "room.exr");
    REQUIRE(again.scene.changes.size() == 1);
    CHECK(again.scene.changes[0].time == 0.2);
}

TEST_CASE("the recording of a scene without files keeps its text, but for a byte order mark", "[tools][live]") {
    const Scratch scratch("# my own words\n", "\xEF\xBB\xBF");
    const std::string recording = recorded(scratch);
    CHECK_THAT(read_whole(recording), Catch::Contains("# my own words"));
    CHECK(read_scene_file(recording).scene.name == "little_honey_recording");
}

TEST_CASE("file paths in a panel, a change or a restart are relative to the scene's folder", "[tools][scene]") {
    const Scratch scratch(std::string(mesh) +
                          "[[panel]]\nset = [\"solid[0].file=other.obj\"]\n[[panel]]\nset = [\"look.environment=room.exr\"]\n");
    const std::vector<SceneFile> panels = panel_scenes(read_scene_file(scratch.scene()));
    REQUIRE(panels.size() == 2);
    CHECK(panels[0].scene.solids.at(0).shape.file == scratch.scenes() / "other.obj");
    CHECK(panels[1].look.environment == scratch.scenes() / "room.exr");

    const Scratch changes("[[change]]\ntime = 0\nkey = \"look.environment\"\nvalue = \"room.exr\"\n");
    CHECK(read_scene_file(changes.scene()).look.environment == changes.scenes() / "room.exr");
}

TEST_CASE("a change to a missing or wrong file is refused at its location", "[tools][scene]") {
    const Scratch scratch(mesh);
    const SceneFile file = read_scene_file(scratch.scene());
    const auto refused = [&](const std::string& key, const std::string& value, const std::string& why) {
        CHECK_THROWS_WITH(changed(file, {{key, placed(Value(value), {"here", 0, 0})}}), Catch::Contains("here: ") && Catch::Contains(why));
    };
    refused("look.environment", "gone.exr", "No such file");
    refused("look.environment", "one.obj", "not an image file");
    refused("solid[0].file", "gone.obj", "no file \"gone.obj\"");
    refused("solid[0].file", std::string(300, 'a'), "no file \"aaa");
}

TEST_CASE("mistakes found after a change name the scene's file, and the change if it made them", "[tools][scene]") {
    const Scratch scratch("");
    const SceneFile file = read_scene_file(scratch.scene());
    const Scene now = changed(file, {{"fluid.viscosity", placed(Value(3.0), {"here", 0, 0})}}).scene;
    CHECK(now.place("fluid.viscosity").file == "here");
    for (const char* key : {"fluid.spacing", "emitter[0].radius", "time.cfl"}) {
        CHECK(now.place(key).file == scratch.scene().string());
        CHECK(now.place(key).line == file.scene.place(key).line);
    }
}

TEST_CASE("a mesh or image path that is not UTF-8 is refused", "[tools][scene]") {
    for (const char* what : {mesh, "[look]\nenvironment = \"room.exr\"\n"}) {
        const Scratch scratch(what);
        fs::rename(scratch.scenes(), scratch / "gr\xfcn");
        CHECK_THROWS_WITH(read_scene_file(scratch / "gr\xfcn/scene.toml"), Catch::Contains("is not UTF-8"));
    }
}

TEST_CASE("a run in a folder whose name is not UTF-8 succeeds, and its report is valid JSON", "[tools][render]") {
    const Scratch scratch("");
    const fs::path run = scratch / "gr\xfcn";
    test::succeed({"render", scratch.scene().string(), "--no-images", "--frames", "1", "--quiet", "--out", run.string()});
    CHECK_THAT(
        test::succeed({"render", scratch.scene().string(), "--no-images", "--frames", "2", "--json", "--overwrite", "--out", run.string()})
            .out,
        Catch::Contains("gr\xEF\xBF\xBDn\",\"frames\":2"));
}

}  // namespace scene_files_test

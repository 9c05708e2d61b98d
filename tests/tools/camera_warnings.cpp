#include <algorithm>
#include <catch2/catch.hpp>

#include "tools/scene_file/scene_changes.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

TEST_CASE("a camera that shows nothing of the scene is reported with its key", "[tools][scene]") {
    bool orbits = false;
    const auto warnings = [&](const std::vector<std::string>& set) {
        Options options;
        options.scene = "honey_coil";
        options.set = set;
        SceneFile file = read_scene_file(options);
        if (orbits) file.camera.kind = "orbit", file.camera.target = Vec3f(0, 9, 0);
        return camera_warnings(file);
    };
    const auto one = [&](const std::vector<std::string>& set) {
        const auto all = warnings(set);
        return all.empty() ? "none" : all[0];
    };
    const std::string fixed = "camera.kind=fixed", ahead = "camera.position=[0, 0.1, 0.4]";
    CHECK(one({fixed, ahead, "camera.target=[0, 0.05, 0]"}) == "none");
    CHECK(one({fixed, ahead, "camera.target=[0, 0.1, 0.4]"}) == "camera: its position is its target, [0, 0.1, 0.4]");
    CHECK(one({fixed, ahead, "camera.target=[0, 0.1, 5]"}).find("camera: from [0, 0.1, 0.4] it does not see the domain") == 0);
    CHECK_THAT(one({fixed, "camera.position=[0, 100, 400]", "camera.target=[0, 0, 0]"}),
               Catch::Contains("of the image's height, seen from 412 m away"));
    CHECK(one({fixed, "camera.position=[0, 1, 0]", "camera.target=[0, 0, 0]"}).find("camera.up = [0, 1, 0]: the camera looks along it") ==
          0);
    CHECK(one({"camera.kind=auto", "camera.min=[-0.1, 0, -0.1]", "camera.max=[0.1, 0.2, 0.1]"}) == "none");
    CHECK(one({"camera.kind=auto", "camera.min=[9, 0, 0]", "camera.max=[9.1, 0.1, 0.1]"}).find("camera: from") == 0);
    CHECK(one({"camera.kind=auto", "camera.min=[-100, 0, -100]", "camera.max=[100, 200, 100]"}).find("camera: the domain covers") == 0);
    // Close-ups smaller than any grid of sample points: part of one side, and the camera inside.
    const std::string box = "domain.min=[-0.5, -0.01, -0.5]", box_too = "domain.max=[0.5, 1, 0.5]";
    CHECK(one({box, box_too, fixed, "camera.position=[0, 0.5, 2]", "camera.target=[0, 0.5, 0]", "camera.fov=5"}) == "none");
    CHECK(one({box, box_too, fixed, "camera.position=[0.06, 0.56, 2]", "camera.target=[0.06, 0.56, 0]", "camera.fov=2"}) == "none");
    CHECK(one({box, box_too, fixed, "camera.position=[0.06, 0.56, 0.1]", "camera.target=[0.06, 0.56, 0]", "camera.fov=2"}) == "none");
    // A shallow pool fills the image's width.
    CHECK(one({"domain.max=[5, 0.15, 0.08]", fixed, "camera.position=[2.5, 0.01, 40]", "camera.target=[2.5, 0.01, 0]"}) == "none");
    const std::string keys = "camera.kind=keys", first = "camera.key[0]={time=0, position=[0, 0.1, 0.4], target=[0, 0.05, 0]}";
    CHECK(one({"camera.kind=orbit", "camera.distance=400"}).find("camera: the domain covers") == 0);
    CHECK(one({"camera.kind=orbit", "camera.target=[0, 9, 0]"}).find("camera: from") == 0);
    CHECK(one({keys, first}) == "none");
    CHECK(one({keys, "camera.key[0]={time=0, position=[0, 1, 0], target=[0, 0, 0]}"})
              .find("camera.up = [0, 1, 0]: the camera looks along it") == 0);
    CHECK(one({keys, first, "camera.key[1]={time=900, position=[0, 0.1, 400], target=[0, 0.05, 700]}"}).find("camera: from") == 0);
    CHECK_THROWS_WITH(one({"camera.up=[0, 0, 0]"}), "--set camera.up=[0, 0, 0]: camera.up is zero");
    CHECK_THROWS_WITH(one({keys}),
                      "--set camera.kind=keys: camera.kind = \"keys\" needs a [[camera.key]]; add at least one, with time and position");
    orbits = true;
    CHECK(one({}).find("it does not see the domain at 0 s") != std::string::npos);
}

namespace {

/// The scenes of its panels that are runs, or else the scene itself. Places no fluid, which takes long at quality fine.
std::vector<SceneFile> runs_of(const SceneFile& file) {
    SceneFile alone = file;
    alone.scene.panels.clear(), alone.scene.output.chart.clear();
    std::vector<SceneFile> runs;
    for (const PanelKeys& panel : file.scene.panels) {
        std::vector<KeyValue> changes;
        for (const std::string& text : panel.set) changes.push_back(parse_change(text));
        if (panel.difference.empty()) runs.push_back(changed(alone, changes));
    }
    return runs.empty() ? std::vector{alone} : runs;
}

}  // namespace

TEST_CASE("no shipped scene and none of its panels gets a camera warning at any quality", "[tools][scene]") {
    for (const auto& [name, path] : shipped_scenes()) {
        if (path.parent_path().filename() != "scenes") continue;  // studies intentionally have no pressure, too few particles, ...
        for (const char* quality : {"draft", "standard", "fine"}) {
            Options options;
            options.scene = path.string();
            options.quality = quality;
            const std::vector<SceneFile> runs = runs_of(read_scene_file(options));
            // Scenes that compare the notes as printed with the amended forms intentionally cause warnings.
            if (std::any_of(runs.begin(), runs.end(), [](const SceneFile& run) { return run.scene.models.printed(); })) continue;
            for (const SceneFile& run : runs) {
                CAPTURE(name, quality, run.scene.models.micropolar);
                CHECK(make_plan(run).warnings == std::vector<std::string>());
            }
        }
    }
}

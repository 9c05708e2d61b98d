#include <catch2/catch.hpp>
#include <fstream>
#include <numbers>

#include "engine/core/errors.h"
#include "tests/support/animated_nodes.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch.h"
#include "tools/scene_file/scene_changes.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

TEST_CASE("camera, emitter and solid follow nodes of a glTF file that the run's settings and inputs name", "[tools][scene]") {
    const test::ScratchFolder scratch;
    test::AnimatedNodes nodes = test::turning_node("Eye", std::numbers::pi / 2, 2, {0, 0.5, 2});
    nodes.json["nodes"][0]["camera"] = 0;
    nodes.json["cameras"] = nlohmann::json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}});
    nodes.write(scratch / "shot.glb");
    const std::string follows = "animation = \"shot.glb\"\n", eye = "node = \"Eye\"\n";
    const auto read = [&](const std::string& camera) {
        std::ofstream(scratch / "scene.toml") << test::text::time(2) + test::text::domain({-3, -3, -3}, {3, 3, 3}) +
                                                     test::text::fluid(0.05, 10) +
                                                     "[[emitter]]\nposition = [0, \"0.1*t\", 0]\nradius = 0.2\nspeed = 1\n" + follows +
                                                     eye + "[[solid]]\nshape = \"sphere\"\nradius = 0.3\n" + follows +
                                                     "node = \"rig\"\n[camera]\nkind = \"animation\"\n" + camera;
        return read_scene_file(scratch / "scene.toml");
    };
    const SceneFile file = read(follows + eye);
    // A quarter turn about y brings the eye from +z to +x.
    const View view = view_at(file.camera, 1, Vec3f::Zero(), Vec3f::Ones());
    CHECK((view.position - Vec3f(2, 0.5f, 0)).norm() < 1e-5f);
    CHECK((view.target - view.position - Vec3f(-1, 0, 0)).norm() < 1e-5f);
    CHECK((view.up - Vec3f(0, 1, 0)).norm() < 1e-5f);
    CHECK(view.fov == Approx(0.5 * 180 / std::numbers::pi));
    const auto inputs = input_checksums(file);
    REQUIRE(inputs.size() == 1);
    CHECK(inputs.begin()->first == (scratch / "shot.glb").string());

    // The resolved scene and a change of another key keep the motions.
    for (const SceneFile& again :
         {read_resolved(resolved_toml(file), "/elsewhere/scene.toml"), changed(file, {parse_change("emitter[0].speed=2")})}) {
        CHECK(again.scene.emitters[0].position(1.3) == file.scene.emitters[0].position(1.3));
        CHECK(again.scene.emitters[0].direction(1.3) == file.scene.emitters[0].direction(1.3));
        CHECK(again.scene.solids[0].rotation(1.3) == file.scene.solids[0].rotation(1.3));
        CHECK(view_at(again.camera, 1.3, Vec3f::Zero(), Vec3f::Ones()).position ==
              view_at(file.camera, 1.3, Vec3f::Zero(), Vec3f::Ones()).position);
    }
    const std::string at = (scratch / "scene.toml").string() + ":24:";
    CHECK_THROWS_WITH(read(follows + "node = \"Ey\"\n"),
                      Catch::StartsWith(at + "8: camera.node: shot.glb has no node \"Ey\"; did you mean \"Eye\"?; allowed: Eye, rig"));
    CHECK_THROWS_WITH(read(eye + "animation = \"none.glb\"\n"), Catch::StartsWith(at + "13: camera.animation: no file \""));
    CHECK_THROWS_WITH(read(follows), Catch::Contains("camera.node is missing"));
    CHECK_THROWS_WITH(changed(file, {parse_change("solid[0].rotation=[0,1,0]")}),
                      Catch::Contains("solid[0] is turned by its keys or its animation"));
}

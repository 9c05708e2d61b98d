#include "engine/scene/motions.h"

#include <catch2/catch.hpp>

#include "engine/core/errors.h"
#include "tests/support/animated_nodes.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch.h"

using namespace whorl;

TEST_CASE("faulty keys and animations of solids and emitters are refused with their location and a fix", "[scene]") {
    const test::ScratchFolder scratch;
    test::AnimatedNodes file = test::turning_node("Spoon", 1, 1);
    file.node("Still");
    file.json["nodes"][0]["scale"] = {1, 1, 1};
    file.write(scratch / "a.glb");
    const auto message = [&](const std::string& keys, bool of_emitter = false) -> std::string {
        const std::string scene =
            test::text::domain({-1, -1, -1}, {1, 1, 1}) + test::text::time(1) + test::text::fluid(0.01) +
            test::text::block({0, 0, 0}, {0.1, 0.1, 0.1}) +
            (of_emitter ? "[[emitter]]\nradius = 0.05\nspeed = 1\n" : "[[solid]]\nshape = \"sphere\"\nradius = 0.1\n") + keys;
        try {
            read_scene_text(scene, (scratch / "scene.toml").string());
        } catch (const InputError& e) {
            std::string all;
            for (const Problem& p : e.problems()) all += p.message().substr((scratch / "scene.toml").string().size() + 1) + "\n";
            return all;
        }
        return "no error";
    };
    const std::string animation = "animation = \"a.glb\"\n", node = "node = \"Spoon\"\n", key = "[[solid.key]]\ntime = 0\n";
    CHECK(message(animation + node) == "no error");
    CHECK(message(key) == "no error");
    CHECK(message(animation + "node = \"Spon\"\n") ==
          "17:8: solid[0].node: a.glb has no node \"Spon\"; did you mean \"Spoon\"?; allowed: Spoon, rig, Still\n");
    for (const auto& [keys, part] : std::vector<std::pair<std::string, std::string>>{
             {animation + "node = \"Still\"\n",
              "17:8: solid[0].node: no animation moves the node \"Still\" or its parents; choose an animated node"},
             {animation, "16:13: solid[0].node is missing; set node to the name of a node of the file"},
             {node, "16:8: solid[0].node needs an animation; set animation"},
             {"animation = \"b.glb\"\n" + node, "16:13: solid[0].animation: no file \"b.glb\""},
             {"animation = \"scene.glb\"\n" + node, "no file \"scene.glb\""},
             {animation + node + "density = 900\n", "18:11: solid[0] has a density, so forces move it, but it has keys or an animation"},
             {animation + node + "rotation = [0, 1, 0]\n", "18:12: solid[0] is turned by its keys or its animation; remove rotation"},
             {animation + node + "pivot = [0, 1, 0]\n",
              "18:9: solid[0].pivot: with an animation the solid turns about the origin of its node"},
             {animation + node + key, "16:13: solid[0] has keys and an animation; remove one of them"},
             {"tilt = [0, 9, 0]\n" + key, "16:8: solid[0] is turned by its keys"},
             {key + "[[solid.key]]\ntime = 0\n", "solid[0].key[1] and solid[0].key[0] are both at 0 s; only the camera may jump"},
             {key + "tlt = [0, 0, 1]\n", "unknown key \"tlt\" in solid[0].key[0]; did you mean \"tilt\"?"}}) {
        CAPTURE(keys);
        CHECK_THAT(message(keys), Catch::Contains(part));
    }
    CHECK_THAT(message("", true), Catch::Contains("13:1: emitter[0].position is missing"));
    CHECK(message("[[emitter.key]]\ntime = 0\nposition = [0, 0, 0]\n", true) == "no error");
    CHECK_THAT(message("[[emitter.key]]\ntime = 0\n", true), Catch::Contains("emitter[0].key[0].position is missing"));
    CHECK(message(animation + node, true) == "no error");
}

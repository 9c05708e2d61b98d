#include "render/look/material.h"

#include <catch2/catch.hpp>

#include "engine/io/snapshot.h"
#include "engine/scene/read.h"
#include "tests/support/runs.h"

using namespace whorl;

TEST_CASE("a scene file accepts exactly the solid materials that can be drawn", "[look]") {
    const Key* key = scene_keys().find_part("solid")->table->find_key("material");
    REQUIRE(key != nullptr);
    CHECK(key->choices == solid_material_names());
    CHECK(*key->standard.as<std::string>() == solid_material_names().front());
}

TEST_CASE("colour, roughness and metallic of a solid override its material, and what is not shown has no mesh", "[look]") {
    const Simulation run = test::simulation_of(R"(
time.end = 0.1
fluid.spacing = 0.01
[[emitter]]
position = [0, 0.2, 0]
radius = 0.02
speed = 0.1
show = false
[[solid]]
shape = "box"
min = [-0.1, -0.1, -0.1]
max = [0.1, 0, 0.1]
material = "wood"
colour = "#bc0000"
metallic = 1
[[solid]]
shape = "sphere"
radius = 0.02
position = [0, 0.05, 0]
show = false
)");
    const Frame frame = Snapshots(run, {}).take(run, 1);
    REQUIRE(frame.solids.size() == 3);
    CHECK(frame.solids[0].mesh);
    CHECK_FALSE(frame.solids[1].mesh);
    CHECK_FALSE(frame.solids[2].mesh);  // the nozzle
    const SolidMaterial board = solid_material(frame.solids[0].appearance), wood = solid_material("wood");
    CHECK((board.colour - Vec3f(0.5029f, 0, 0)).norm() < 1e-3f);  // sRGB 188/255 is 0.503 in linear light (IEC 61966-2-1)
    CHECK(board.metal == 1);
    CHECK(board.roughness == wood.roughness);
    CHECK(board.pattern == wood.pattern);
}

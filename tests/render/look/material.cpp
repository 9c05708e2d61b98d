#include "render/look/material.h"

#include <algorithm>
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
    Simulation run = test::simulation_of(R"(
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
    test::run_until(run, 0.02);
    const auto role = run.world().fluid.column<field::role>();
    REQUIRE(role.size() > 0);
    CHECK(Snapshots(run, {}).take(run, 2).position.size() ==
          static_cast<std::size_t>(std::count(role.begin(), role.end(), 0)));  // not the fluid in the nozzle
    const SolidMaterial board = solid_material(frame.solids[0].appearance), wood = solid_material("wood");
    CHECK((board.colour - Vec3f(0.5029f, 0, 0)).norm() < 1e-3f);  // sRGB 188/255 is 0.503 in linear light (IEC 61966-2-1)
    CHECK(board.metal == 1);
    CHECK(board.roughness == wood.roughness);
    CHECK(board.pattern == wood.pattern);
}

TEST_CASE("light fades inside cream and milk about as measured", "[look]") {
    // sqrt(3 s (s + t)) from the absorption s and scattering t of Jensen et al. (2001), table 1. Here one mean free path stands for three
    // bands, and a colour near white hardly limits the absorption.
    const auto fading = [](const char* name) {
        LookOptions look;
        look.material = name;
        return diffuse_attenuation(fluid_material(look, 0.1f));
    };
    const auto check = [](const Vec3f& found, const Vec3f& measured) {
        INFO(found.transpose());
        CHECK((found.array() > 0.5f * measured.array()).all());
        CHECK((found.array() < 1.6f * measured.array()).all());
    };
    check(fading("cream"), Vec3f(67, 214, 393));
    check(fading("milk"), Vec3f(92, 152, 399));
}

TEST_CASE("light spreads further inside a body with a longer mean free path", "[look]") {
    LookOptions look;
    look.style = "opaque", look.material = "paint", look.colour = {0.8f, 0.4f, 0.1f};
    CHECK(fluid_material(look, 0.1f).scattering == 0);
    look.scattering = 1e-3f;
    const Material paint = fluid_material(look, 0.1f);
    const Vec3f fades = diffuse_attenuation(paint), reach = sideways_reach(paint);
    CHECK(fades.x() < fades.y());
    CHECK(fades.y() < fades.z());
    CHECK(reach.x() > reach.y());
    look.scattering = 2e-3f;
    CHECK(diffuse_attenuation(fluid_material(look, 0.1f)).isApprox(fades / 2));
    CHECK(sideways_reach(fluid_material(look, 0.1f)).isApprox(2 * reach));
}

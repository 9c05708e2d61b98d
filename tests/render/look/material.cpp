#include "render/look/material.h"

#include <catch2/catch.hpp>

#include "engine/scene/read.h"

using namespace whorl;

TEST_CASE("a scene file accepts exactly the solid materials that can be drawn", "[look]") {
    const Key* key = scene_keys().find_part("solid")->table->find_key("material");
    REQUIRE(key != nullptr);
    CHECK(key->choices == solid_material_names());
    CHECK(*key->standard.as<std::string>() == solid_material_names().front());
}

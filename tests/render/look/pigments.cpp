#include <catch2/catch.hpp>

#include "render/look/colour_map.h"
#include "render/look/material.h"

using namespace whorl;

TEST_CASE("thick ink has its pure colour on any ground, and without ink the ground's colour remains", "[render][ink]") {
    for (const float ground : {0.0f, 0.3f, 1.0f}) {
        const Pigments pigments({"#1e50a0", "#e6b400"}, Vec3f::Constant(ground));
        Vec3f blue;
        REQUIRE(read_colour("#1e50a0", blue));
        // Light that passes an opaque layer: less than 1/255 of white, and 6 % for yellow, which absorbs least.
        CHECK((pigments(Vec3f(1, 0, 0)) - linear_of(blue)).cwiseAbs().maxCoeff() < 0.02f);
        CHECK((pigments(Vec3f::Zero()) - Vec3f::Constant(ground)).norm() == 0);
    }
}

TEST_CASE("blue and yellow make green, and thinning ink changes continuously to the ground", "[render][ink]") {
    const Pigments pigments({"#1e50a0", "#e6b400"}, Vec3f::Ones());
    const Vec3f mixed = pigments(Vec3f(0.5f, 0.5f, 0));
    CHECK(mixed.y() > 1.5f * mixed.x());
    CHECK(mixed.y() > 1.5f * mixed.z());
    Vec3f before = pigments(Vec3f::Zero());
    CHECK((pigments(Vec3f(1e-3f, 0, 0)) - before).cwiseAbs().maxCoeff() < 0.03f);
    for (int n = 1; n <= 1000; ++n) {
        const Vec3f after = pigments(Vec3f(static_cast<float>(n) / 1000, 0, 0));
        CHECK((after.array() <= before.array() + 1e-5f).all());
        before = after;
    }
}

TEST_CASE("colours are six hexadecimal digits", "[render][ink]") {
    Vec3f colour;
    CHECK(read_colour("#FF8000", colour));
    CHECK((colour - Vec3f(1, 128.0f / 255, 0)).norm() < 1e-6f);
    for (const char* wrong : {"", "red", "#ff800", "#ff80000", "#ff80gg", "ff8000"}) CHECK_FALSE(read_colour(wrong, colour));
}

#include "render/look/colour_map.h"

#include <catch2/catch.hpp>

using namespace whorl;

namespace {

float lightness(const char* map, float t) { return lab_of(map_colour(map, t)).x(); }

}  // namespace

TEST_CASE("colour maps pass through their published colours", "[render]") {
    // Entries of the published tables that are not stored in the program, which interpolates stored entries and rounds them to 8 bits.
    CHECK((map_colour("viridis", 0) - Vec3f(0.267f, 0.005f, 0.329f)).cwiseAbs().maxCoeff() < 0.002f);
    CHECK((map_colour("viridis", 0.5f) - Vec3f(0.128f, 0.567f, 0.551f)).cwiseAbs().maxCoeff() < 0.01f);
    CHECK((map_colour("viridis", 1) - Vec3f(0.993f, 0.906f, 0.144f)).cwiseAbs().maxCoeff() < 0.002f);
    CHECK((map_colour("inferno", 0.25f) - Vec3f(0.342f, 0.062f, 0.429f)).cwiseAbs().maxCoeff() < 0.01f);
    CHECK((map_colour("inferno", 1) - Vec3f(0.988f, 0.998f, 0.645f)).cwiseAbs().maxCoeff() < 0.002f);
    CHECK((map_colour("coolwarm", 0) - Vec3f(0.230f, 0.299f, 0.754f)).cwiseAbs().maxCoeff() < 0.01f);
    CHECK((map_colour("coolwarm", 1) - Vec3f(0.706f, 0.016f, 0.150f)).cwiseAbs().maxCoeff() < 0.01f);
}

TEST_CASE("perceptual maps get lighter evenly: equal steps of value give equal steps of lightness", "[render]") {
    for (const char* map : {"viridis", "inferno"}) {
        const float first = lightness(map, 0), mean = (lightness(map, 1) - first) / 100;
        for (int n = 0; n < 100; ++n) {
            const float t = static_cast<float>(n) / 100, step = lightness(map, t + 0.01f) - lightness(map, t);
            INFO(map << " at " << t << ": a step of " << step << ", " << mean << " in the mean");
            // The published maps are even in CAM02-UCS, whose lightness is not quite CIE's: single steps differ by up to half.
            REQUIRE(step > 0.5f * mean);
            REQUIRE(step < 1.5f * mean);
            REQUIRE(std::abs(lightness(map, t) - first - 100 * t * mean) < 6);
        }
    }
}

TEST_CASE("the signed map is equally light on both sides, and lightest in its middle", "[render]") {
    float last = 101;
    for (int n = 0; n <= 50; ++n) {
        const float s = static_cast<float>(n) / 100, cool = lightness("coolwarm", 0.5f - s), warm = lightness("coolwarm", 0.5f + s);
        INFO("at a distance of " << s << " from the middle: " << cool << " and " << warm);
        REQUIRE(std::abs(cool - warm) < 0.7f);
        REQUIRE(cool < last);
        last = cool;
    }
}

TEST_CASE("the diverging map is a light grey in its middle, without a step", "[render]") {
    const Vec3f middle = map_colour("coolwarm", 0.5f);
    CHECK(middle.maxCoeff() - middle.minCoeff() < 0.03f);
    CHECK(middle.minCoeff() > 0.8f);
    CHECK((map_colour("coolwarm", 0.499f) - map_colour("coolwarm", 0.501f)).cwiseAbs().maxCoeff() < 0.01f);
}

#include "render/look/colour_map.h"

#include <catch2/catch.hpp>

using namespace whorl;

TEST_CASE("colour maps begin and end in their known colours", "[render]") {
    // The published tables' ends; the polynomials are fits, good to 0.03 a channel.
    CHECK((map_colour("viridis", 0) - Vec3f(0.267f, 0.005f, 0.329f)).cwiseAbs().maxCoeff() < 0.03f);
    CHECK((map_colour("viridis", 1) - Vec3f(0.993f, 0.906f, 0.144f)).cwiseAbs().maxCoeff() < 0.03f);
    CHECK((map_colour("inferno", 0.25f) - Vec3f(0.342f, 0.062f, 0.429f)).cwiseAbs().maxCoeff() < 0.03f);
    CHECK((map_colour("inferno", 1) - Vec3f(0.988f, 0.998f, 0.645f)).cwiseAbs().maxCoeff() < 0.03f);
    CHECK((map_colour("coolwarm", 0) - Vec3f(0.230f, 0.299f, 0.754f)).cwiseAbs().maxCoeff() < 0.01f);
    CHECK((map_colour("coolwarm", 1) - Vec3f(0.706f, 0.016f, 0.150f)).cwiseAbs().maxCoeff() < 0.01f);
}

TEST_CASE("the diverging map is a light grey in its middle, without a step", "[render]") {
    const Vec3f middle = map_colour("coolwarm", 0.5f);
    CHECK(middle.maxCoeff() - middle.minCoeff() < 0.03f);
    CHECK(middle.minCoeff() > 0.8f);
    CHECK((map_colour("coolwarm", 0.499f) - map_colour("coolwarm", 0.501f)).cwiseAbs().maxCoeff() < 0.01f);
}

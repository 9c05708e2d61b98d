#include <catch2/catch.hpp>

#include "render/surface/smooth.h"
#include "tests/support/shapes.h"

using namespace whorl;

TEST_CASE("the sharp edges of a box are its twelve, of a cylinder its two rims", "[render]") {
    // Each face of the box has its own corners, at the same positions: they are merged.
    CHECK(sharp_edges(test::box_mesh(Vec3f(0, 0, 0), Vec3f(1, 2, 3))).size() == 12);
    const auto rims = sharp_edges(test::cylinder_mesh(Vec3f(0, 1, 0), 0.5f, 2));
    CHECK(rims.size() == 2 * 96);
    for (const auto& [a, b] : rims) CHECK(a.y() == b.y());
}

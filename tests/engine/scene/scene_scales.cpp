#include "engine/scene/scene_scales.h"

#include <catch2/catch.hpp>

#include "tests/support/poured_honey.h"

using namespace whorl;
using test::plan_with;

TEST_CASE("the expected speed includes a solid that is fastest at the start", "[plan]") {
    const std::string pushed = R"_(solid[1]={shape="sphere", radius=0.01, position=["0.05*(1-exp(-100*t))", 0.05, 0]})_";
    CHECK(plan_with({"models.pressure=ppe", pushed}).expected_speed == Approx(5).epsilon(0.03));
}

TEST_CASE("the expected speed of a fall is by the largest gravity of the run", "[plan]") {
    const double steady = plan_with({}).expected_speed;
    for (const std::string varying : {"exp(-t)", "exp(t-4)"})
        CHECK(plan_with({R"(domain.gravity=[0, "-9.81*)" + varying + "\", 0]"}).expected_speed == Approx(steady));
}

TEST_CASE("the longest side of a box does not depend on where the box is", "[plan]") {
    for (const Vec3d& at : {Vec3d(0, 0, 0), Vec3d(5, -7, 3)}) {
        Extent box;
        box.min = at, box.max = at + Vec3d(1, 2, 3);
        CHECK(longest_side(box, 3) == Approx(3));
        CHECK(longest_side(box, 2) == Approx(2));
    }
}

#include "render/look/environment.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/errors.h"
#include "render/image/exr.h"
#include "tests/support/scratch.h"

using namespace whorl;

namespace {

/// Radiance by direction.
template <class F>
Environment all_round(F&& radiance) {
    Environment environment{64, 32, {}};
    environment.rgb.resize(3 * 64 * 32);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c) environment.rgb[3 * (64 * y + x) + c] = radiance(environment.direction(x, y));
    return environment;
}

}  // namespace

TEST_CASE("the image's middle is towards -z, its right towards +x, its top up", "[look]") {
    const Environment environment{64, 32, {}};
    CHECK((environment.direction(32, 16) - Vec3f(0, 0, -1)).norm() < 0.08f);
    CHECK(environment.direction(48, 16).x() > 0.99f);
    CHECK(environment.direction(5, 0).y() > 0.99f);
}

TEST_CASE("under an even sky a white surface gives back the sky's radiance, whichever way it faces", "[look]") {
    const auto light = light_of(all_round([](const Vec3f&) { return 2.0f; }));
    for (const Vec3f& n : {Vec3f(0, 1, 0), Vec3f(0, -1, 0), Vec3f(0.6f, 0, -0.8f)})
        CHECK(light_on(light, n).x() == Approx(2).epsilon(2e-3));  // the sum over 32 rows
}

TEST_CASE("under half a sky a surface receives all, half or none of its light by its orientation", "[look]") {
    const auto light = light_of(all_round([](const Vec3f& d) { return d.x() > 0 ? 1.0f : 0.0f; }));
    CHECK(light_on(light, Vec3f(1, 0, 0)).x() == Approx(1).margin(0.04));  // the contribution of the third order and higher
    CHECK(light_on(light, Vec3f(0, 0, 1)).x() == Approx(0.5).margin(0.04));
    CHECK(light_on(light, Vec3f(-1, 0, 0)).x() == Approx(0).margin(0.04));
    CHECK(brightest_side(light).x() > 0.8f);
    CHECK(brightest_side(light).y() > 0.5f);  // at least 35 degrees above the horizon
}

TEST_CASE("an EXR panorama is read as linear light, invalid values as 0, and other files are refused", "[look]") {
    const test::ScratchFolder folder;
    write_exr(folder / "two.exr", {2, 1, {1, 0.5f, 0.25f, 1, -4, INFINITY, NAN, 1}}, {});
    const Environment two = read_environment(folder / "two.exr");
    REQUIRE(two.width == 2);
    CHECK(two.rgb == std::vector<float>{1, 0.5f, 0.25f, 0, 0, 0});
    CHECK_THROWS_AS(read_environment(folder / "none.exr"), InputError);
    write_png(folder / "a.png", plain_image(4, 4, 9));
    CHECK_THROWS_AS(read_environment(folder / "a.png"), InputError);
    write_exr(folder / "wide.exr", {20000, 1, std::vector<float>(80000, 1)}, {});
    CHECK_THROWS_WITH(read_environment(folder / "wide.exr"), Catch::Contains("at most 16384 x 16384"));
}

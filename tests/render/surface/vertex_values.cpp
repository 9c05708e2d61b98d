#include "render/surface/vertex_values.h"

#include <catch2/catch.hpp>

#include "render/surface/surface.h"

using namespace whorl;

TEST_CASE("what particles carry reaches the surface as the mean of those near by", "[render][surface]") {
    const std::vector<Vec3f> particle{{0, 0, 0}, {1, 0, 0}, {10, 0, 0}};
    const std::vector<float> value{2, 4, 9};
    const std::vector<Vec3f> vertex{{0.5f, 0, 0}, {0, 0, 0}, {10, 0.5f, 0}, {5, 5, 5}};
    const std::vector<float> found = values_at(vertex, particle, value, 2);
    CHECK(found[0] == Approx(3));                          // half-way between the two
    CHECK(found[1] == Approx((2 + 4 * 0.5625) / 1.5625));  // (1 - 1/4)^2 for the one that is half the reach away
    CHECK(found[2] == Approx(9));
    CHECK(found[3] == 0);  // nobody there
}

TEST_CASE("a surface tells the fluid's age at its vertices where the frame knows it, and none where it does not", "[render][surface]") {
    Frame frame;
    frame.spacing = 0.1f;
    frame.domain_min = Vec3f::Constant(-1), frame.domain_max = Vec3f::Constant(2);
    for (int i = 0; i < 10; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k)
                frame.position.push_back(0.1f * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)));
    CHECK(build_surface(frame, {}).age.empty());
    for (const Vec3f& x : frame.position) frame.scalar["age"].push_back(x.x());
    const Surface surface = build_surface(frame, {});
    REQUIRE(surface.age.size() == surface.mesh.position.size());
    for (std::size_t v = 0; v < surface.age.size(); ++v)
        CHECK(surface.age[v] == Approx(std::clamp(surface.mesh.position[v].x(), 0.0f, 0.9f))
                                    .margin(0.08));  // the mean over 0.2 of a linear field, cut off at the ends
}

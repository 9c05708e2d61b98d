#include "engine/core/triangle.h"

#include <catch2/catch.hpp>

#include "engine/core/types.h"

using namespace whorl;

TEST_CASE("the nearest point of a triangle lies on its face, an edge or a corner", "[core]") {
    const Vec3d a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
    const auto check = [&](const Vec3d& p, const Vec3d& point, int feature) {
        const auto nearest = nearest_on_triangle(p, a, b, c);
        INFO(p.transpose());
        CHECK((nearest.point - point).norm() < 1e-14);
        CHECK(nearest.feature == feature);
    };
    check({0.5, 0.5, 3}, {0.5, 0.5, 0}, 6);
    check({-1, -1, 1}, a, 0);
    check({4, -1, 0}, b, 1);
    check({-1, 4, 0}, c, 2);
    check({2, 2, 1}, {1, 1, 0}, 3);
    check({-1, 1, 1}, {0, 1, 0}, 4);
    check({1, -1, 0}, {1, 0, 0}, 5);
}

TEST_CASE("a triangle of zero area still has a nearest point", "[core]") {
    const Vec3f a(1, 1, 1);
    CHECK(nearest_on_triangle<float>(Vec3f(0, 0, 0), a, a, a).point == a);
}

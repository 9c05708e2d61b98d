#include "render/gl/setup.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

using namespace whorl;

TEST_CASE("a jittered matrix shifts every point by the same number of pixels, at any depth", "[render]") {
    const View view{Vec3f(0, 0.1f, 0.6f), Vec3f(0, 0.1f, 0), Vec3f(0, 1, 0), 30};
    Bounds bounds;
    bounds.add(Vec3f(-0.1f, 0, -0.1f)), bounds.add(Vec3f(0.1f, 0.2f, 0.1f));
    const Eigen::Matrix4f matrix = camera_matrix(view, 2, bounds), shifted = jittered(matrix, {0.5f, -0.25f}, 80, 40);
    for (const float z : {-0.1f, 0.1f}) {
        const Eigen::Vector4f x(0.05f, 0.07f, z, 1);
        const Eigen::Vector3f moved = (shifted * x).hnormalized() - (matrix * x).hnormalized();
        CHECK(moved.x() * 40 == Approx(0.5f).epsilon(1e-4));  // half the width in pixels
        CHECK(moved.y() * 20 == Approx(-0.25f).epsilon(1e-4));
        CHECK(moved.z() == Approx(0).margin(1e-6));
    }
}

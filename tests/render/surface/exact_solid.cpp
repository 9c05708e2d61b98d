/// Boxes, cylinders and balls found in meshes.
#include "render/surface/exact_solid.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "engine/geometry/shape.h"

using namespace whorl;

namespace {

ShapeKeys exact_keys(const std::string& kind, bool open) {
    ShapeKeys keys;
    keys.kind = kind;
    if (kind == "box") keys.min = {-1, 2, -3}, keys.max = {1, 5, -1};
    else if (kind == "cylinder") keys.from = {1, 2, 3}, keys.to = {1, 4, 3}, keys.radius = 0.7;
    else keys.radius = 1.5;
    if (open) keys.open = "top", keys.wall = 0.2;
    if (open && kind == "sphere") keys.rim = 0.5;
    return keys;
}

TEST_CASE("exact solids of boxes, cylinders and spheres, open or closed, have the distances of the shapes", "[surface]") {
    // 1e-5: single precision. Beyond edges the distance is a lower bound, so points are compared near the surface, off its edges.
    const auto shape = make_shape(exact_keys(GENERATE("box", "cylinder", "sphere"), GENERATE(false, true)));
    const auto solid = exact_solid(shape->mesh(Real(0.1), 0));
    REQUIRE(solid);
    const Mat3f turn = Eigen::AngleAxisf(0.7f, Vec3f(1, 2, 3).normalized()).toRotationMatrix();
    const ExactSolid placed = moved(*solid, turn, Vec3f(0.3f, 0, 1));
    int near = 0, wrong = 0;
    for (int k = 0; k < 20000; ++k) {
        const auto part = [&](float step) { return std::fmod(step * static_cast<float>(k), 1.0f); };
        const Vec3f x(-2 + 4 * part(0.8191725f), -2 + 7.5f * part(0.6710436f), -3.5f + 7.5f * part(0.5497005f));
        const float expected = static_cast<float>(shape->distance(x.cast<Real>()));
        if (std::abs(expected) > 0.09f) continue;
        ++near;
        const float off = solid->distance(x), off_placed = placed.distance(turn * x + Vec3f(0.3f, 0, 1));
        wrong += (off < 0) != (expected < 0) || std::abs(off) > std::abs(expected) + 1e-5f || std::abs(off - off_placed) > 1e-5f ? 1 : 0;
    }
    CHECK(near > 100);
    CHECK(wrong == 0);
}

TEST_CASE("meshes of other shapes are not exact solids", "[surface]") {
    ShapeKeys keys;
    keys.kind = GENERATE("cone", "torus", "capsule");
    keys.from = {0, 0, 0}, keys.to = {0, 2, 0}, keys.radius = 0.7, keys.tube = 0.2;
    CHECK_FALSE(exact_solid(make_shape(keys)->mesh(Real(0.1), 0)));
    TriangleMesh dented = make_sphere({0, 0, 0}, 1)->mesh(Real(0.1), 0);
    dented.position[dented.position.size() / 2] *= 0.99f;
    CHECK_FALSE(exact_solid(dented));
}

}  // namespace

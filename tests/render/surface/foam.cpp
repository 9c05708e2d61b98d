#include "render/surface/foam.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/shapes.h"

using namespace whorl;

namespace foam_points_test {

namespace {

/// A row of particles along x, 1 cm apart, with foam 0, 0.25, 0.5, 0.75 and 1.
Frame row() {
    Frame frame;
    frame.spacing = 0.01f;
    frame.domain_min = Vec3f::Constant(-1), frame.domain_max = Vec3f::Constant(1);
    for (int k = 0; k < 5; ++k) {
        frame.position.emplace_back(0.01f * static_cast<float>(k), 0, 0);
        frame.velocity.emplace_back(1, 2, 0);
        frame.scalar["foam"].push_back(0.25f * static_cast<float>(k));
        frame.scalar["airborne"].push_back(k == 4 ? 0.1f : 0);
        frame.scalar["grain"].push_back(0.17f * static_cast<float>(k));
    }
    return frame;
}

/// One particle of a frame.
Frame only(const Frame& frame, std::size_t i) {
    Frame one = frame;
    one.position = {frame.position[i]}, one.velocity = {frame.velocity[i]};
    for (auto& [name, values] : one.scalar) values = {frame.scalar.at(name)[i]};
    return one;
}

}  // namespace

TEST_CASE("a particle has more points of foam the more air it has, near it and with its velocity", "[render]") {
    const Frame frame = row();
    std::size_t before = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const std::vector<FoamPoint> points = foam_points(only(frame, i), 1);
        CHECK((i == 0 ? points.empty() : points.size() > before));
        before = points.size();
        for (const FoamPoint& p : points) {
            CHECK((p.position - frame.position[i]).norm() < 1.5f * frame.spacing);
            CHECK(p.velocity == frame.velocity[i]);
            CHECK(p.opacity > 0);
            CHECK(p.opacity <= 1);
        }
    }
    CHECK(foam_points(frame, 2).size() > foam_points(frame, 1).size());
    CHECK(foam_points(frame, 0).empty());
    Frame bare = frame;
    bare.scalar.clear();
    CHECK(foam_points(bare, 1).empty());
}

TEST_CASE("a particle's points do not depend on its place among the others", "[render]") {
    const Frame frame = row();
    const std::vector<FoamPoint> all = foam_points(frame, 1), one = foam_points(only(frame, 3), 1);
    const auto same = [](const FoamPoint& a, const FoamPoint& b) { return a.position == b.position && a.radius == b.radius; };
    CHECK(std::search(all.begin(), all.end(), one.begin(), one.end(), same) != all.end());
}

TEST_CASE("points of foam stay inside a container", "[render]") {
    Frame frame = row();
    FrameSolid tank;
    tank.mesh = std::make_shared<const TriangleMesh>(test::box_mesh(Vec3f(-0.005f, -0.005f, -0.005f), Vec3f(0.045f, 0.2f, 0.2f)));
    tank.container = true;
    frame.solids.push_back(tank);
    const std::vector<FoamPoint> points = foam_points(frame, 1);
    REQUIRE(points.size() > 50);
    for (const FoamPoint& p : points)
        if (!p.mist) CHECK((p.position.array() > Vec3f(-0.005f, -0.005f, -0.005f).array()).all());
}

TEST_CASE("particles of spray are left out of the surface, and their points part from each other", "[render]") {
    const Frame frame = row(), part = without_spray(frame);
    CHECK(part.position.size() == 4);
    CHECK(part.scalar.at("foam").size() == 4);
    CHECK(part.position.back() == frame.position[3]);
    const std::vector<FoamPoint> points = foam_points(only(frame, 4), 1);
    CHECK(std::any_of(points.begin(), points.end(), [&](const FoamPoint& p) { return (p.velocity - frame.velocity[4]).norm() > 0.1f; }));
}

}  // namespace foam_points_test

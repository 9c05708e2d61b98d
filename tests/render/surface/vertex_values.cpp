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

TEST_CASE("what the fluid carries to its surface is exact for linear fields, above the last layer of particles too", "[render][surface]") {
    Frame frame;
    frame.spacing = 0.1f;
    const auto field = [](const Vec3f& x) { return Vec3f(2 * x.x() - x.y(), 3 * x.y() + 1, x.z()); };
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j)
            for (int k = 0; k < 8; ++k) {
                const auto n = static_cast<float>(64 * i + 8 * j + k);  // not on a lattice
                frame.position.push_back(0.1f * Vec3f(static_cast<float>(i) + 0.2f * std::sin(5 * n),
                                                      static_cast<float>(j) + 0.2f * std::sin(7 * n),
                                                      static_cast<float>(k) + 0.2f * std::cos(3 * n)));
            }
    for (const Vec3f& x : frame.position) {
        frame.velocity.push_back(field(x));
        frame.scalar["viscosity"].push_back(1 + x.x());
        frame.scalar["age"].push_back(x.x() - 0.35f);
        frame.vector["ink"].push_back(Vec3f(2 * x.y(), 0, 1));
    }
    const std::vector<Vec3f> point{{0.35f, 0.75f, 0.35f}, {-0.05f, 0.3f, 0.4f}, {0.31f, 0.42f, 0.33f}, {5, 5, 5}};
    const VertexFields found = carried_at(point, frame, 0.2f);
    const auto& velocity = found.vector.at("velocity");
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK((velocity[k] - field(point[k])).norm() < 2e-5f);  // rounding: velocities are up to 3
        CHECK(found.scalar.at("viscosity")[k] == Approx(1 + point[k].x()).margin(1e-5));
        CHECK(found.scalar.at("age")[k] == Approx(std::max(0.0f, point[k].x() - 0.35f)).margin(1e-5));  // no age is negative
        CHECK(found.vector.at("ink")[k].x() == Approx(std::clamp(2 * point[k].y(), 0.0f, 1.0f)).margin(2e-5));
    }
    CHECK(velocity[3] == Vec3f::Zero());  // nobody there

    // One sheet of particles says nothing about the direction across it: there the field goes on as it is.
    Frame sheet = frame;
    sheet.vector.clear(), sheet.scalar.clear(), sheet.velocity.clear();
    for (Vec3f& x : sheet.position) x.z() = 0, sheet.velocity.push_back(field(x));
    CHECK((carried_at(std::vector<Vec3f>{{0.35f, 0.35f, 0.05f}}, sheet, 0.2f).vector.at("velocity")[0] - field({0.35f, 0.35f, 0})).norm() <
          2e-5f);
}

#include "render/surface/vertex_values.h"

#include <catch2/catch.hpp>

#include "render/surface/surface.h"
#include "tests/support/shapes.h"

using namespace whorl;

TEST_CASE("vertex values are the mean of near particles", "[render][surface]") {
    const std::vector<Vec3f> particle{{0, 0, 0}, {1, 0, 0}, {10, 0, 0}};
    const std::vector<float> value{2, 4, 9};
    const std::vector<Vec3f> vertex{{0.5f, 0, 0}, {0, 0, 0}, {10, 0.5f, 0}, {5, 5, 5}};
    const std::vector<float> found = values_at(vertex, particle, value, 2);
    CHECK(found[0] == Approx(3));                          // half-way between the two
    CHECK(found[1] == Approx((2 + 4 * 0.5625) / 1.5625));  // (1 - 1/4)^2 for the one that is half the reach away
    CHECK(found[2] == Approx(9));
    CHECK(found[3] == 0);  // no particle there
}

TEST_CASE("a surface has the fluid's age at its vertices if and only if the frame has it", "[render][surface]") {
    Frame frame;
    frame.spacing = 0.1f;
    frame.domain_min = Vec3f::Constant(-1), frame.domain_max = Vec3f::Constant(2);
    frame.position = test::lattice(10, 4, 4, 0.1f);
    CHECK(build_surface(frame, {}).age.empty());
    for (const Vec3f& x : frame.position) frame.scalar["age"].push_back(x.x());
    const Surface surface = build_surface(frame, {});
    REQUIRE(surface.age.size() == surface.mesh.position.size());
    for (std::size_t v = 0; v < surface.age.size(); ++v)
        CHECK(surface.age[v] == Approx(std::clamp(surface.mesh.position[v].x(), 0.0f, 0.9f))
                                    .margin(0.08));  // the mean over 0.2 of a linear field, cut off at the ends
}

TEST_CASE("a surface glows by its temperatures: 1400 K as new lava, 150 K less as lava aged by cooling", "[render][surface]") {
    Frame frame;
    frame.spacing = 0.1f;
    frame.domain_min = Vec3f::Constant(-1), frame.domain_max = Vec3f::Constant(2);
    frame.position = test::lattice(6, 4, 4, 0.1f);
    CHECK_FALSE(build_surface(frame, {}).glows_by_temperature);
    for (const auto& [kelvin, age] : {std::pair(1500.0f, 0.0f), {1400.0f, 0.0f}, {1250.0f, 1.0f}}) {
        frame.scalar["temperature"].assign(frame.position.size(), kelvin);
        const Surface surface = build_surface(frame, {});
        CHECK(surface.glows_by_temperature);
        REQUIRE(surface.age.size() == surface.mesh.position.size());
        for (const float found : surface.age) REQUIRE(found == Approx(age).margin(1e-4));
    }
}

TEST_CASE("linear fields are exact at vertices within the range of values of the particles in reach", "[render][surface]") {
    Frame frame;
    frame.spacing = 0.1f;
    const auto field = [](const Vec3f& x) { return Vec3f(2 * x.x() - x.y(), 3 * x.y() + 1, x.z()); };
    frame.position = test::lattice(8, 8, 8, 0.1f);
    float n = 0;
    for (Vec3f& x : frame.position) {
        x += 0.02f * Vec3f(std::sin(5 * n), std::sin(7 * n), std::cos(3 * n)), ++n;  // not on a lattice
        frame.velocity.push_back(field(x));
        frame.scalar["viscosity"].push_back(1 + x.x());
        frame.scalar["age"].push_back(x.x() - 0.35f);
        frame.vector["ink"].push_back(Vec3f(2 * x.y(), 0, 1));
    }
    const std::vector<Vec3f> point{{0.35f, 0.75f, 0.35f}, {-0.05f, 0.3f, 0.4f}, {0.31f, 0.42f, 0.33f}, {5, 5, 5}};
    const VertexFields found = carried_at(point, frame, 0.2f);
    const auto& velocity = found.vector.at("velocity");
    for (std::size_t k = 0; k < 3; ++k) {
        // The fields are linear in x, so a bound on a field of one coordinate is a bound on that coordinate.
        Vec3f least = Vec3f::Constant(9), most = -least;
        for (const Vec3f& x : frame.position)
            if ((x - point[k]).norm() < 0.2f) least = least.cwiseMin(x), most = most.cwiseMax(x);
        const Vec3f x = point[k].cwiseMax(least).cwiseMin(most);
        CHECK(velocity[k].tail(2).isApprox(field(x).tail(2), 1e-5f));  // rounding
        CHECK(std::abs(velocity[k].x() - field(point[k]).x()) < 2e-5f);
        CHECK(found.scalar.at("viscosity")[k] == Approx(1 + x.x()).margin(1e-5));
        CHECK(found.scalar.at("age")[k] == Approx(x.x() - 0.35f).margin(1e-5));
        CHECK(found.vector.at("ink")[k].x() == Approx(2 * x.y()).margin(2e-5));
    }
    CHECK(velocity[3] == Vec3f::Zero());  // no particle there

    // One sheet of particles does not determine the gradient across it: the field is constant in that direction.
    Frame sheet = frame;
    sheet.vector.clear(), sheet.scalar.clear(), sheet.velocity.clear();
    for (Vec3f& x : sheet.position) x.z() = 0, sheet.velocity.push_back(field(x));
    CHECK((carried_at(std::vector<Vec3f>{{0.35f, 0.35f, 0.05f}}, sheet, 0.2f).vector.at("velocity")[0] - field({0.35f, 0.35f, 0})).norm() <
          2e-5f);
}

TEST_CASE("splashes carry no value outside those of the particles in reach", "[render][surface]") {
    Frame frame;
    frame.spacing = 0.1f;
    for (const float apart : {0.0f, 1e-8f, 1e-4f, 0.03f, 0.1f}) {  // a lone particle, and pairs at one position and apart
        const auto n = static_cast<float>(frame.position.size());
        frame.position.push_back({n, 0.37f, 0.11f});
        frame.position.push_back({n + apart, 0.37f, 0.11f});
        frame.velocity.push_back({2, 0.1f, 0}), frame.velocity.push_back({0, 2, 1e-3f});
        for (const float age : {0.1f, 0.4f}) frame.scalar["age"].push_back(age);
    }
    std::vector<Vec3f> point;
    for (int k = 0; k < 400; ++k)
        point.push_back(frame.position[k % 10] + 0.09f * Vec3f(std::sin(5.0f * k), std::sin(7.0f * k), std::cos(3.0f * k)));
    const VertexFields found = carried_at(point, frame, 0.2f);
    for (const Vec3f& v : found.vector.at("velocity")) {
        CHECK((v.minCoeff() >= -1e-6f && v.head(2).maxCoeff() <= 2.00001f && v.y() >= 0.09999f && v.z() <= 1.001e-3f));
        CHECK(v.norm() <= 2.00251f);
    }
    for (const float age : found.scalar.at("age")) CHECK((age >= 0.1f && age <= 0.4f));
}

TEST_CASE("values are carried across the faces of a periodic domain", "[render][surface]") {
    Frame frame;
    frame.spacing = 0.1f;
    frame.domain_min = Vec3f::Zero(), frame.domain_max = Vec3f(1, 0.4f, 0.4f);
    frame.periodic = {true, false, false};
    for (int i = 0; i < 10; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k) {
                frame.position.push_back(0.1f *
                                         Vec3f(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f, static_cast<float>(k) + 0.5f));
                frame.velocity.push_back(Vec3f(1, 2, frame.position.back().y()));
            }
    const VertexFields found = carried_at(std::vector<Vec3f>{{0, 0.2f, 0.2f}, {0.5f, 0.2f, 0.2f}, {1, 0.2f, 0.2f}}, frame, 0.2f);
    for (const Vec3f& v : found.vector.at("velocity")) CHECK((v - Vec3f(1, 2, 0.2f)).norm() < 1e-5f);
}

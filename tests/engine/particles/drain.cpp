#include "engine/particles/drain.h"

#include <catch2/catch.hpp>

using namespace whorl;

namespace {

ParticleStore particles_at(const std::vector<Vec3>& places) {
    ParticleStore fluid;
    fluid.declare(field_info<field::position>(), true);
    fluid.declare(field_info<field::role>(), true);
    fluid.declare(field_info<field::time_in_drain>(), true);
    fluid.resize(static_cast<Index>(places.size()));
    std::copy(places.begin(), places.end(), fluid.column<field::position>().begin());
    return fluid;
}

std::shared_ptr<const Shape> unit_box() {
    ShapeKeys keys;
    keys.kind = "box";
    keys.min = Vec3d::Zero(), keys.max = Vec3d::Ones();
    return make_shape(keys);
}

}  // namespace

TEST_CASE("a drain removes particles inside it, and keeps the order of those outside or in a nozzle", "[drain]") {
    ParticleStore fluid = particles_at({{2, 0, 0}, {0.5, 0.5, 0.5}, {3, 0, 0}, {0.2, 0.5, 0.5}, {0.7, 0.7, 0.7}});
    fluid.column<field::role>()[3] = -1;
    CHECK(drain(fluid, {{unit_box(), 0}}, Real(0.01)) == 2);
    REQUIRE(fluid.size() == 3);
    const auto x = fluid.column<field::position>();
    CHECK(x[0].x() == 2);
    CHECK(x[1].x() == 3);
    CHECK(x[2].x() == Real(0.2));
}

TEST_CASE("a delayed drain removes particles after that time inside, counted again when they return", "[drain]") {
    ParticleStore fluid = particles_at({{0.5, 0.5, 0.5}, {0.2, 0.5, 0.5}});
    const std::vector<Drain> drains{{unit_box(), Real(0.25)}};
    for (int step = 0; step < 2; ++step) CHECK(drain(fluid, drains, Real(0.1)) == 0);
    fluid.column<field::position>()[1].x() = 2;
    CHECK(drain(fluid, drains, Real(0.1)) == 1);
    REQUIRE(fluid.size() == 1);
    fluid.column<field::position>()[0].x() = Real(0.2);
    for (int step = 0; step < 2; ++step) CHECK(drain(fluid, drains, Real(0.1)) == 0);
    CHECK(drain(fluid, drains, Real(0.1)) == 1);
}

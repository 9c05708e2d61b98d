// Shapes in a periodic domain.
#include "engine/geometry/repeats.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "engine/core/random.h"
#include "engine/geometry/shape.h"
#include "engine/geometry/solids.h"

using namespace whorl;

namespace repeats_test {

namespace {

Domain unit_cube(std::array<bool, 3> periodic) {
    Domain domain;
    domain.periodic = periodic;
    return domain;
}

/// Distance to the nearest of all images up to three periods away.
Real least_of_images(const Solid& solid, const Domain& domain, const Vec3& x) {
    Real least = std::numeric_limits<Real>::max();
    for (int k = 0; k < 343; ++k) {
        const Vec3 n(static_cast<Real>(k % 7 - 3), static_cast<Real>(k / 7 % 7 - 3), static_cast<Real>(k / 49 - 3));
        const Vec3 at = x + n.cwiseProduct(domain.period());
        least = std::min(least, solid.shape->distance(solid.pose.rotation.transpose() * (at - solid.pose.translation)));
    }
    return least;
}

Vec3 anywhere(RandomNumbers& random) { return Vec3d(random(), random(), random()).cast<Real>(); }

}  // namespace

TEST_CASE("in a periodic domain a solid's distance is the least over its images, moved and turned in any way", "[geometry][periodic]") {
    const std::vector<std::shared_ptr<const Shape>> shapes = {make_box({0.1, 0.2, 0.3}, {0.5, 0.4, 0.9}), make_sphere({0.9, 0.1, 0.5}, 0.3),
                                                              make_cylinder({0, 0, 0}, {0.3, 0.2, 0.6}, 0.15),
                                                              make_mesh(make_box({0, 0, 0}, {0.3, 0.2, 0.4})->mesh(0, 0), "box")};
    const auto periodic = GENERATE(std::array<bool, 3>{true, true, true}, std::array<bool, 3>{false, true, false});
    RandomNumbers random(3);
    for (const auto& shape : shapes)
        for (int pose = 0; pose < 8; ++pose) {
            Solids solids;
            solids.domain = unit_cube(periodic);
            Solid solid;
            solid.shape = shape;
            solid.inside = pose % 2 == 1;
            solid.turn = turn_by(3 * anywhere(random).cast<double>()).toRotationMatrix();
            const Vec3d moved = 3 * anywhere(random).cast<double>() - Vec3d::Constant(1.5);
            solid.shift = Vec3d(periodic[0] ? moved[0] : 0, moved[1], periodic[2] ? moved[2] : 0);
            solids.all.push_back(solid);
            solids.set_time(0, 0);
            for (int k = 0; k < 40; ++k) {
                const Vec3 x = anywhere(random);
                const Real expected = (solid.inside ? -1 : 1) * least_of_images(solids.all[0], solids.domain, x);
                REQUIRE(solids.all[0].distance(x) == Approx(expected).margin(2e-6));  // rounding at coordinates up to 3
                // Moves towards the surface by the distance along the normal, and stays on the fluid's side.
                if (expected > 0 && !solid.inside)
                    REQUIRE(std::abs(solids.all[0].distance(x - expected * solids.all[0].normal(x))) < 1e-4f);
            }
        }
}

TEST_CASE("a shape as long as the period has no ends along it, at any offset", "[geometry][periodic]") {
    const Domain domain = unit_cube({true, false, false});
    for (const double first : {0.0, 0.3, -0.7}) {
        Solids solids;
        solids.domain = domain;
        Solid channel;
        channel.shape = make_box({first, 0.2, -1}, {first + 1, 0.8, 2});
        channel.inside = true;
        solids.all = {channel};
        solids.set_time(0, 0);
        for (const double x : {0.0, 0.3, 0.30001, 0.65, 0.99999})
            CHECK(solids.all[0].distance(Vec3(static_cast<Real>(x), Real(0.3), Real(0.5))) == Approx(0.1).margin(1e-6));
        CHECK(solids.all[0].normal(Vec3(static_cast<Real>(first + 1e-3), Real(0.25), Real(0.5))).y() == 1);
    }
    const auto rod = std::make_shared<Repeated>(make_cylinder({0.4, 0.5, 0.5}, {1.4, 0.5, 0.5}, 0.1), domain);
    CHECK(rod->distance(Vec3(Real(0.4), Real(0.5), Real(0.5))) == Approx(-0.1).margin(1e-6));
}

TEST_CASE("every image of a rotating solid has the solid's surface velocity", "[geometry][periodic]") {
    Solids solids;
    solids.domain = unit_cube({true, true, true});
    Solid wheel;
    wheel.shape = make_sphere({0, 0, 0}, 0.2);
    wheel.spin.component[2] = Expression(2);
    solids.all = {wheel};
    solids.set_time(0, 1e-3);
    for (const double x : {0.1, 1.1, -2.9}) CHECK(solids.all[0].velocity_at({static_cast<Real>(x), 0, 0}).y() == Approx(0.2).epsilon(1e-3));
    CHECK(solids.all[0].velocity_at({Real(0.9), 1, 0}).y() == Approx(-0.2).epsilon(1e-3));
}

TEST_CASE("a solid that crosses a periodic face is drawn on both sides", "[geometry][periodic]") {
    const Domain domain = unit_cube({true, true, false});
    const Repeats corner(*make_sphere({0, 2, 0.5}, 0.2), domain), middle(*make_sphere({2.5, 0.5, 0.5}, 0.2), domain);
    CHECK(corner.shifts_into(domain).size() == 4);
    REQUIRE(middle.shifts_into(domain).size() == 1);
    CHECK(middle.shifts_into(domain)[0] == Vec3(-2, 0, 0));
}

}  // namespace repeats_test

/// The angle at which a drop meets a plate.
#include <catch2/catch.hpp>
#include <numbers>

#include "engine/geometry/plane.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/constraint.h"
#include "engine/models/pressure/damping.h"
#include "engine/models/surface_tension/surface_tension.h"
#include "engine/particles/sample.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/world.h"

using namespace whorl;

namespace wetting_test {

namespace {

constexpr double sigma = 0.07, rho = 1000, d = 1e-3, pi = std::numbers::pi;
const double unit = std::sqrt(rho * d * d * d / sigma);

/// Height of the centre of mass of a spherical cap of volume 1 that meets the ground at this angle.
double cap_centre(double angle) {
    const double ground = std::cos(angle);  // the cap is the part of the unit ball about the origin above this height; sums over its slices
    double volume = 0, moment = 0;
    const int n = 2000;
    for (int k = 0; k < n; ++k) {
        const double y = ground + (1 - ground) * (k + 0.5) / n, slice = pi * (1 - y * y) * (1 - ground) / n;
        volume += slice, moment += slice * (y - ground);
    }
    return moment / volume / std::cbrt(volume);
}

/// Angle [degrees] of the spherical cap of the drop's volume whose centre of mass is as high as the drop's.
double contact_angle(Span<const Vec3> x) {
    double height = 0;
    for (const Vec3& one : x) height += static_cast<double>(one.y()) / static_cast<double>(x.size());
    height /= d * std::cbrt(static_cast<double>(x.size()));
    double low = 0.01, high = pi - 0.01;
    for (int k = 0; k < 50; ++k) (cap_centre((low + high) / 2) < height ? low : high) = (low + high) / 2;
    return low * 180 / pi;
}

double young(double wetting) { return std::acos(2 * wetting - 1) * 180 / pi; }

}  // namespace

TEST_CASE("a drop on a plate that it slides along nears the angle with cos = 2 wetting - 1, within 12 degrees",
          "[validation][surface_tension][regression]") {
    // Half a ball (90 degrees), 8 to 12 spacings across: half a spacing of height is 5 to 8 degrees. Measured: 112 and 61 degrees for 120
    // and 60 degrees.
    double before = 200;
    for (const double wetting : {0.25, 0.75}) {
        test::TestWorld w(
            d, 2, Domain{Vec3(Real(-16 * d), 0, Real(-16 * d)), Vec3(Real(16 * d), Real(24 * d), Real(16 * d)), {false, false, false}});
        w.add_wall(1, 1, 0, std::numeric_limits<double>::infinity());
        w.world.solids.all.back().shape = make_plane(Vec3d::Zero(), Vec3d(0, 1, 0));
        PressureOptions options;
        options.limits = {1e-3, 1000};
        options.slow_correction = true;  // as scenes with surface tension have it
        w.use({make_stage("surface tension", "", SurfaceTension{{sigma, {static_cast<Real>(wetting)}, nullptr, true}}),
               make_stage("unresolved motion", "", DampUnresolved{2, sigma}),
               make_stage("density constraint", "", ConstraintPressure{options}), make_stage("move", "", Move{})});
        ShapeKeys ball;
        ball.kind = "sphere";
        ball.radius = 6.2 * d;
        std::vector<Vec3> x;
        for (const Vec3& one : sample_shape(*make_shape(ball), Sampling::blue_noise, Real(d),
                                            Domain{Vec3::Constant(Real(-10 * d)), Vec3::Constant(Real(10 * d)), {}}, 1))
            if (one.y() > 0) x.push_back(one);
        w.put(x);
        w.world.step.gravity.setZero();
        for (int k = 0; k < 700; ++k) {
            w.step(0.15 * unit);
            for (Vec3& u : w.column<field::velocity>()) u *= Real(0.97);
        }
        const double angle = contact_angle(w.column<field::position>());
        WARN("wetting " << wetting << ": " << angle << " degrees, by Young " << young(wetting));
        CHECK(std::abs(angle - young(wetting)) < 12);
        CHECK(angle < before);
        before = angle;
    }
}

TEST_CASE("a drop that sticks to its plate spreads to the angle with cos = 2 wetting - 1 and no further",
          "[validation][surface_tension][long]") {
    // Half a ball of 0.1 Pa s, 8 spacings in radius. Measured with wetting 0.9: 38 degrees after 1 s, 36 from 2 s on, 37 by theory. Half a
    // spacing of height is 6 degrees. If large pressure forces were not expected in the next step, the drop would go on to 25 degrees.
    const double wetting = 0.9;
    Simulation drop =
        test::simulation_of(test::text::time(4) + test::text::domain({-0.02, -0.01, -0.02}, {0.02, 0.02, 0.02}, "gravity = [0, 0, 0]") +
                            test::text::fluid(d, 0.1, "surface_tension = 0.07") + test::text::models("ppe", "full") +
                            test::text::drop({0, 0, 0}, 8 * d, "sampling = \"blue_noise\"") +
                            test::text::plane({0, 0, 0}, {0, 1, 0}, "slip = \"no\"\nwetting = 0.9"));
    for (const double end : {2.0, 4.0}) {
        test::run_until(drop, end);
        const double angle = contact_angle(drop.world().fluid.column<field::position>());
        WARN("after " << end << " s " << angle << " degrees, by Young " << young(wetting));
        CHECK(std::abs(angle - young(wetting)) < 6);
    }
}

}  // namespace wetting_test

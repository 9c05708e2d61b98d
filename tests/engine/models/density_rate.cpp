/// The density of the constraint, its derivative, and the gate before solids.
#include "engine/models/pressure/density_rate.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/random.h"
#include "engine/geometry/plane.h"
#include "engine/models/pressure/body_rows.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace density_rate_test {

namespace {

constexpr double d = 0.01;

/// Jittered fluid above a floor. The lower face of its lowest layer is at the given height [d].
struct Floor : TestWorld {
    std::vector<Real> rho, rate, bend;
    Real bend_step = 0;  ///< s, for which `bend` is measured; 0: `bend` is not measured
    /// @param mirrors number of flat walls with images; they meet at right angles in a corner of the fluid
    explicit Floor(double height, int mirrors = 0, bool periodic = false)
        : TestWorld(d, 2, Domain{Vec3::Zero(), Vec3::Constant(Real(20 * d)), {periodic, false, false}}) {
        use({});
        add_wall(1, +1, 0);
        const double at = mirrors >= 2 ? 0 : 5 * d, deep = mirrors == 3 ? 0 : 5 * d;
        if (mirrors >= 2) add_wall(0, +1, 0);
        if (mirrors == 3) add_wall(2, +1, 0);
        if (mirrors > 0) world.boundary_particles.flat.assign(static_cast<std::size_t>(world.boundary_particles.size()), 1);
        RandomNumbers random(3);
        place(Vec3(Real(at), Real(height * d), Real(deep)), Vec3(Real(at + 6 * d), Real((height + 5) * d), Real(deep + 6 * d)), 0,
              [&](const Vec3&) { return Vec3(Real(random() - 0.5), Real(random() - 0.5), Real(random() - 0.5)); });
        for (Vec3& x : column<field::position>())
            for (int a = 0; a < 3; ++a) x[a] += static_cast<Real>(0.1 * d * (2 * random() - 1));
    }
    void measure(Real threshold) {
        find_pairs();
        rho.resize(world.fluid.size());
        rate.resize(rho.size());
        DensityRate D;
        D.build(WallImage(world.step.kernel, world.step.support, world.step.spacing, SolidGate{threshold}), world.context(),
                Read<field::role>{std::as_const(world.fluid).column<field::role>()},
                Read<field::velocity>{std::as_const(world.fluid).column<field::velocity>()}, rho, rate);
        if (bend_step == 0) return;
        world.step.dt = bend_step;
        bend.resize(rho.size());
        D.bend(WallImage(world.step.kernel, world.step.support, world.step.spacing, SolidGate{threshold}), world.context(), rho,
               column<field::velocity>(), BodyRows{}.poses_after({}, world.solids), bend);
    }
    void move(double dt) {
        const auto x = column<field::position>();
        const auto u = column<field::velocity>();
        for (std::size_t i = 0; i < x.size(); ++i) x[i] += static_cast<Real>(dt) * u[i];
    }
};

}  // namespace

TEST_CASE("at a wall the density rate is the density's derivative within 1 %, with and without a gate", "[pressure][boundary]") {
    // Central difference over +-0.005 d. The remainder is the error of the difference (third derivatives of the kernel jump at R/2) and
    // round-off in float.
    for (const double threshold : {0.0, 0.1, -1.0, -2.0, -3.0}) {
        INFO("gate " << threshold << "; -1 to -3: none, and images in 1 to 3 walls");
        Floor fluid(0, static_cast<int>(std::max(0.0, -threshold)));
        const double dt = 0.005 * d / 0.5;
        fluid.measure(static_cast<Real>(threshold));
        const std::vector<Real> rate = fluid.rate;
        fluid.move(dt), fluid.measure(static_cast<Real>(threshold));
        const std::vector<Real> later = fluid.rho;
        fluid.move(-2 * dt), fluid.measure(static_cast<Real>(threshold));
        double wrong = 0, all = 0;
        for (std::size_t i = 0; i < rate.size(); ++i) {
            const double difference = (static_cast<double>(later[i]) - fluid.rho[i]) / (2 * dt);
            wrong += std::pow(difference - rate[i], 2), all += std::pow(difference, 2);
        }
        CHECK(std::sqrt(wrong / all) < 0.01);
    }
}

TEST_CASE("at a wall the curvature term is the density change beyond its rate, with and without a gate", "[pressure][boundary]") {
    // Particles move by up to 0.2 d relative to each other along each axis. Neighbours that enter the support are ignored: W is near 0
    // there.
    for (const double threshold : {0.0, 0.1, -1.0, -2.0, -3.0}) {
        INFO("gate " << threshold << "; -1 to -3: none, and images in 1 to 3 walls");
        Floor fluid(0, static_cast<int>(std::max(0.0, -threshold)));
        const double dt = 0.1 * d / 0.5;
        fluid.bend_step = static_cast<Real>(dt);
        fluid.measure(static_cast<Real>(threshold));
        const std::vector<Real> before = fluid.rho, rate = fluid.rate, bend = fluid.bend;
        fluid.move(dt), fluid.measure(static_cast<Real>(threshold));
        double wrong = 0, all = 0;
        for (std::size_t i = 0; i < rate.size(); ++i) {
            const double left_out = static_cast<double>(fluid.rho[i]) - before[i] - dt * rate[i];
            wrong += std::pow(left_out - bend[i], 2), all += std::pow(left_out, 2);
        }
        CHECK(std::sqrt(all / static_cast<double>(rate.size())) > 2);  // kg/m^3
        CHECK(std::sqrt(wrong / all) < 0.02);
    }
}

TEST_CASE("fluid that turns with a solid keeps its density at first order, and its curvature is right", "[pressure][boundary]") {
    // The rate vanishes by symmetry; left is round-off. A step of 0.1 radians takes fluid 10 d from the axis .05 d outward.
    Floor fluid(0);
    World& world = fluid.world;
    Solid& floor = world.solids.all[0];
    floor.shape = make_plane(Vec3d::Zero(), Vec3d::UnitY());
    const Vec3 w(Real(1), Real(0.5), Real(-2)), centre = floor.centre().cast<Real>();
    floor.pose.angular_velocity = w, floor.pose.velocity = -w.cross(centre);
    world.boundary_particles.own_normal = world.boundary_particles.normal;
    world.boundary_particles.follow(world.solids);
    const auto x = fluid.column<field::position>();
    const auto u = fluid.column<field::velocity>();
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = floor.pose.velocity_at(x[i]);
    const double dt = 0.1 / static_cast<double>(w.norm());
    fluid.bend_step = static_cast<Real>(dt);
    fluid.measure(0);
    const std::vector<Real> before = fluid.rho, rate = fluid.rate, bend = fluid.bend;
    fluid.move(dt);
    floor.pose.rotation = turn_by(dt * w.cast<double>()).toRotationMatrix().cast<Real>();
    floor.pose.translation = centre - floor.pose.rotation * centre;
    world.boundary_particles.follow(world.solids);
    fluid.measure(0);
    double wrong = 0, all = 0;
    for (std::size_t i = 0; i < rate.size(); ++i) {
        CHECK(std::abs(rate[i]) < 0.02);  // of 1000 kg/m^3 and 2.3 radians a second
        const double change = static_cast<double>(fluid.rho[i]) - before[i];
        wrong += std::pow(change - bend[i], 2), all += std::pow(change, 2);
    }
    CHECK(std::sqrt(all / static_cast<double>(rate.size())) > 2);  // kg/m^3
    CHECK(std::sqrt(wrong / all) < 0.02);
}

TEST_CASE("a gate excludes a wall from the density until the fluid is near, and includes all at contact", "[pressure][boundary]") {
    // Without a gate the wall acts from half a spacing above contact on (its image is nearly twice as far); with a gate of 0.1 it does not
    // act on a layer 0.35 d above contact.
    Floor high(0.35), touching(0);
    high.measure(0);
    const std::vector<Real> felt = high.rho;
    high.measure(Real(0.1));
    double most = 0;
    for (std::size_t i = 0; i < felt.size(); ++i) most = std::max(most, static_cast<double>(felt[i] - high.rho[i]));
    CHECK(most > 1);  // kg/m^3
    high.world.boundary_particles = {};
    const std::vector<Real> gated = high.rho;
    high.measure(0);
    for (std::size_t i = 0; i < gated.size(); ++i) CHECK(gated[i] == Approx(high.rho[i]).epsilon(1e-6));
    // In contact the gate is open for the lowest layer, whose weight lies beyond one and a half thresholds.
    touching.measure(0);
    const std::vector<Real> open = touching.rho;
    touching.measure(Real(0.05));
    const auto x = touching.column<field::position>();
    for (std::size_t i = 0; i < open.size(); ++i)
        if (x[i].y() < Real(0.6 * d)) CHECK(touching.rho[i] == Approx(open[i]).epsilon(1e-6));
}

TEST_CASE("images in a wall act across a periodic face as they do inside", "[pressure][boundary]") {
    Floor fluid(0, 1, true);
    fluid.measure(0);
    const std::vector<Real> inside = fluid.rho;
    for (Vec3& x : fluid.column<field::position>()) x.x() += Real(12 * d);  // by whole spacings of the wall, half of it past the face
    fluid.measure(0);
    for (std::size_t i = 0; i < inside.size(); ++i) REQUIRE(fluid.rho[i] == Approx(inside[i]).epsilon(1e-4));
}

}  // namespace density_rate_test

/// Particle shifting.
#include "engine/models/motion/fickian.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/random.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace fickian_test {

namespace {

constexpr double d = 0.01;

/// Jittered particles in shear, u = (10 y, 0, 0) + drift: in a box of 12 d, periodic or not.
TestWorld sheared(bool periodic, const Vec3& drift) {
    const Vec3 end = Vec3::Constant(Real(12 * d));
    TestWorld w(d, 2, periodic ? Domain{Vec3::Zero(), end, {true, true, true}} : Domain{Vec3(-1, -1, -1), Vec3(1, 1, 1), {}});
    w.use({make_stage("density", "density", Density{}), make_stage("shift", "shifting", FickianShift{})});
    w.place(Vec3::Zero(), end, 0, [&](const Vec3& x) { return Vec3(Vec3(10 * x.y(), 0, 0) + drift); });
    RandomNumbers random(3);
    for (Vec3& x : w.column<field::position>())
        for (int a = 0; a < 3; ++a) x[a] += static_cast<Real>(0.15 * d * (2 * random() - 1));
    return w;
}

/// Root mean square of rho/rho_0 - 1 over the particles.
double spread(TestWorld& w) {
    double sum = 0;
    const auto rho = w.column<field::density>();
    double mean = 0;
    for (const Real one : rho) mean += one;
    mean /= static_cast<double>(rho.size());
    for (const Real one : rho) sum += std::pow(one / mean - 1, 2);
    return std::sqrt(sum / static_cast<double>(rho.size()));
}

}  // namespace

TEST_CASE("shifting evens out jittered particles in a shear flow and keeps their velocities", "[shifting]") {
    TestWorld w = sheared(true, Vec3::Zero());
    const std::vector<Vec3> before(w.column<field::velocity>().begin(), w.column<field::velocity>().end());
    w.step(5e-3);
    const double start = spread(w);
    for (int k = 0; k < 20; ++k) w.step(5e-3);  // positions move by the shift only, in a shear of 1
    CHECK(start > 0.01);
    CHECK(spread(w) < 0.5 * start);
    CHECK(std::equal(before.begin(), before.end(), w.column<field::velocity>().begin()));
}

TEST_CASE("shifting is Galilean invariant, and zero without relative motion", "[shifting]") {
    TestWorld still = sheared(true, Vec3::Zero()), drifting = sheared(true, Vec3(3, -2, 1));
    still.step(5e-3), drifting.step(5e-3);
    const auto a = still.column<field::shift>(), b = drifting.column<field::shift>();
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max<double>(largest, a[i].norm()), difference = std::max<double>(difference, (a[i] - b[i]).norm());
    CHECK(largest > 1e-3 * d);
    CHECK(largest < 0.0501 * d);
    CHECK(difference < 1e-4 * d);  // round-off of 3 m/s in single precision against differences of .1 m/s
    for (Vec3& u : still.column<field::velocity>()) u = Vec3(3, -2, 1);
    still.step(5e-3);
    for (const Vec3& move : still.column<field::shift>()) REQUIRE(move.norm() == 0);
}

TEST_CASE("particles at a free surface are hardly shifted outward, those inside are shifted", "[shifting]") {
    TestWorld w = sheared(false, Vec3::Zero());
    w.step(5e-3);
    const auto x = w.column<field::position>();
    const auto move = w.column<field::shift>();
    double surface = 0, inside = 0;
    Index at_surface = 0, within = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const bool outer = x[i].minCoeff() < 0.7 * d || x[i].maxCoeff() > 11.3 * d;
        (outer ? surface : inside) += move[i].norm();
        ++(outer ? at_surface : within);
    }
    // Jitter makes a few per cent of them count as inside.
    CHECK(surface / at_surface < 0.05 * inside / within);
}

TEST_CASE("the shift is proportional to the largest velocity difference from a neighbour", "[shifting]") {
    TestWorld unit = sheared(true, Vec3::Zero()), w = sheared(true, Vec3::Zero());
    RandomNumbers random(11);
    for (Vec3& u : unit.column<field::velocity>()) u = Vec3(random() < 0.5 ? 0 : 1, 0, 0);  // 1 m/s between any particle and some neighbour
    for (Vec3& u : w.column<field::velocity>()) u = Vec3(static_cast<Real>(random()), static_cast<Real>(random()), 0);
    unit.step(1e-5), w.step(1e-5);  // far below the limit of the shift
    const auto u = w.column<field::velocity>();
    const auto shift = w.column<field::shift>(), of_unit = unit.column<field::shift>();
    double most = 0, off = 0;
    for (Index i = 0; i < w.world.fluid.size(); ++i) {
        Real fastest = 0;
        w.world.fluid_pairs.of(i, [&](Index j, const Vec3&, Real) { fastest = std::max(fastest, (u[i] - u[j]).norm()); });
        most = std::max<double>(most, shift[i].norm()), off = std::max<double>(off, (shift[i] - fastest * of_unit[i]).norm());
    }
    CHECK(off < 1e-4 * most);
}

}  // namespace fickian_test

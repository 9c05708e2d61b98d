#include "engine/models/viscosity/coupled/coupled_solve.h"

#include <catch2/catch.hpp>

#include "tests/support/coupled_world.h"

using namespace whorl;
using namespace whorl::test;

namespace coupled_solve_test {

namespace {

constexpr Real d = 0.002;

}  // namespace

TEST_CASE("a viscous blob keeps its momentum to 1e-5 while it changes shape", "[models][coupled]") {
    std::vector<Vec3> x = blue_noise_cylinder(Real(2.5) * d, 16 * d, d);
    CoupledWorld w(x, d, Real(0.05));
    auto u = w.velocity();
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = Vec3(Real(0.1) - x[i][0] * 10, x[i][1] * 20 - Real(0.3), -x[i][2] * 10);
    const auto momentum = [&] {
        Vec3d p = Vec3d::Zero();
        for (const Vec3& v : w.velocity()) p += v.cast<double>();
        return p;
    };
    const Vec3d before = momentum();
    for (int k = 0; k < 60; ++k) { CHECK(w.step(Real(1e-3))); }
    CHECK((momentum() - before).norm() < 1e-5 * before.norm());
}

TEST_CASE("a rigid rotation keeps its angular momentum within 1 % over a second", "[models][coupled]") {
    std::vector<Vec3> x;
    for (const Vec3& p : blue_noise_cylinder(Real(2.5) * d, 8 * d, d)) x.push_back(p - Vec3(0, 4 * d, 0));
    CoupledWorld w(x, d, 1);
    const Vec3 omega(0, 1, 5);
    auto u = w.velocity();
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = omega.cross(x[i]);
    const auto momentum = [&] {
        Vec3d L = Vec3d::Zero();
        for (std::size_t i = 0; i < x.size(); ++i) L += w.position()[i].cast<double>().cross(w.velocity()[i].cast<double>());
        return L;
    };
    const Vec3d before = momentum();
    for (int k = 0; k < 250; ++k) w.step(Real(4e-3));
    CHECK((momentum() - before).norm() < 0.01 * before.norm());
}

namespace {

struct Floor : Shape {
    Real distance(const Vec3& x) const override { return std::abs(x[1] + Real(0.1) * d) - Real(0.1) * d; }  // a plate 0.2 d thin
    Vec3 normal(const Vec3& x) const override { return x[1] > Real(-0.1) * d ? Vec3(Vec3::UnitY()) : Vec3(-Vec3::UnitY()); }
    void bounds(Vec3& low, Vec3& high) const override { low = Vec3(-1, -Real(0.2) * d, -1), high = Vec3(1, 0, 1); }
    TriangleMesh mesh(Real, Real) const override { return {}; }
};

CoupledWorld falling_blob(bool slides) {
    std::vector<Vec3> x;
    for (const Vec3& p : blue_noise_cylinder(3 * d, 6 * d, d)) x.push_back(p + Vec3(0, 2 * d, 0));
    CoupledWorld w(x, d, Real(0.5));
    Solid plate;
    plate.shape = std::make_shared<Floor>();
    if (slides) plate.slip_length = std::numeric_limits<double>::infinity();
    w.world.solids.all.push_back(plate);
    w.world.step.gravity = Vec3(Real(slides ? 2 : 0), Real(-9.81), 0);
    for (Vec3& u : w.velocity()) u = Vec3(0, Real(-0.3), 0);
    return w;
}

}  // namespace

TEST_CASE("a blob that falls on a plate thinner than a step's path sticks to it", "[models][coupled]") {
    CoupledWorld w = falling_blob(false);
    for (int k = 0; k < 40; ++k) w.step(Real(0.006));  // 0.9 d per step at the impact
    int stuck = 0;
    Real lowest = 1;
    for (std::size_t i = 0; i < w.position().size(); ++i) {
        lowest = std::min(lowest, w.position()[i][1]);
        if (w.position()[i][1] > Real(0.6) * d) continue;
        ++stuck;
        CHECK(w.velocity()[i].norm() < 0.005);
    }
    CHECK(stuck > 5);
    CHECK(lowest > Real(0.29) * d);
}

TEST_CASE("on a free-slip plate a blob slides freely and does not sink in", "[models][coupled]") {
    CoupledWorld w = falling_blob(true);
    double time = 0;
    for (int k = 0; k < 60; ++k, time += 0.004) w.step(Real(0.004));
    double sideways = 0;
    Real lowest = 1;
    for (std::size_t i = 0; i < w.position().size(); ++i) {
        sideways += w.velocity()[i][0];
        lowest = std::min(lowest, w.position()[i][1]);
        CHECK(w.role()[i] == 0);
    }
    // Accelerated by 2 m/s^2 along the plate, without friction.
    CHECK(sideways / double(w.position().size()) == Approx(2 * time).epsilon(0.01));
    CHECK(lowest > Real(0.25) * d);
}

}  // namespace coupled_solve_test

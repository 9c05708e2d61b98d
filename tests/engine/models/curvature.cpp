#include "engine/models/strain/curvature.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/viscous_block.h"

using namespace whorl;
using namespace whorl::test;

namespace curvature_test {

namespace {

/// G of the straight move that brings a body which turns by `angle` about z from one place to the next: forward from where it is, or to
/// where it is.
Mat3 straight_turn(double angle, double dt, bool forward) {
    const double turned = forward ? angle : -angle, sign = forward ? 1 : -1;
    Mat3d R = Mat3d::Identity();
    R.topLeftCorner<2, 2>() << std::cos(turned), -std::sin(turned), std::sin(turned), std::cos(turned);
    return (sign / dt * (R - Mat3d::Identity())).cast<Real>();
}

}  // namespace

TEST_CASE("without the curvature a body that turns strains at first order in the step, with it at third", "[viscosity]") {
    // sym G of the new velocities is (cos a - 1)/dt in the plane, T of the old ones -cos a (1 - cos a)/dt: what is left is -(1 - cos
    // a)^2/dt.
    const double dt = 0.1;
    for (const double angle : {0.2, 0.1}) {
        const Mat3 G = straight_turn(angle, dt, true), D = Real(0.5) * (G + G.transpose());
        const Mat3 T = curvature_strain(straight_turn(angle, dt, false), static_cast<Real>(dt));
        const double shrinking = (1 - std::cos(angle)) / dt;
        CHECK(D(0, 0) == Approx(-shrinking).epsilon(1e-4));
        CHECK(T(0, 0) == Approx(-shrinking * std::cos(angle)).epsilon(1e-4));
        CHECK((D - T).norm() < 2 * shrinking * shrinking * dt);
    }
}

TEST_CASE("the curvature of a stretching at constant rate is that of the rate in the middle of the move, to second order", "[viscosity]") {
    Mat3 G = Mat3::Zero();
    G.diagonal() << 2, -1, -1;
    const Real dt = Real(0.02);
    const Mat3 middle = G * (Mat3::Identity() + dt / 2 * G).inverse(), T = curvature_strain(G, dt);
    CHECK((G - T - middle).norm() < 1.5e-3);         // (dt/2)^2 |G|^3 = 9e-4
    CHECK(T.trace() == Approx(0.06).epsilon(1e-4));  // volume: dt/2 tr(G G) = -dt I2
}

TEST_CASE("the curvature never exceeds a fifth of the gradient", "[viscosity]") {
    Mat3 G = Mat3::Zero();
    G(0, 1) = -1000, G(1, 0) = 1000;  // one radian a step
    CHECK(curvature_strain(G, Real(1e-3)).norm() == Approx(0.2 * G.norm()));
}

TEST_CASE("the gradient before the forces is exact for linear fields, in a free block and beside a wall that the fluid sticks to",
          "[viscosity][boundary]") {
    Mat3 wanted;
    wanted << 1, 2, 3, -4, 5, 6, 7, -8, -6;
    for (const bool wall : {false, true}) {
        const Stage stage = make_stage("gradient", "viscosity", VelocityGradient{});
        TestWorld w = uneven_block(1, Real(0.2), {stage});
        if (wall) w.add_wall(1, +1, -0.4);
        if (wall) wanted.col(0).setZero(), wanted.col(2).setZero();  // at rest on y = -0.4
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        for (std::size_t i = 0; i < x.size(); ++i) u[i] = wanted * (x[i] + Vec3(0, Real(0.4), 0));
        w.step(0.01);
        double worst = 0;
        for (const Mat3& G : w.column<field::velocity_gradient>()) worst = std::max(worst, double((G - wanted).norm()));
        CHECK(worst < 1e-4 * wanted.norm());
    }
}

TEST_CASE("a single file of particles and a sheet that turn have the curvature of a body", "[viscosity]") {
    const double angle = 0.05, dt = 0.1;
    for (const Vec3& half : {Vec3(Real(0.4), Real(0.05), Real(0.05)), Vec3(Real(0.4), Real(0.05), Real(0.4))}) {
        TestWorld w = uneven_block(1, 0, {make_stage("gradient", "viscosity", VelocityGradient{})}, half);
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        const Mat3 turn = straight_turn(angle, dt, false);  // about z: the line and the sheet lie along x and z
        for (std::size_t i = 0; i < x.size(); ++i) u[i] = turn * x[i];
        w.step(dt);
        for (const Mat3& G : w.column<field::velocity_gradient>()) {
            const Mat3 T = curvature_strain(G, static_cast<Real>(dt));
            CHECK(T(0, 0) == Approx((std::cos(angle) - 1) / dt).epsilon(0.01));
            CHECK(std::abs(T(2, 2)) < 1e-5);
        }
    }
}

}  // namespace curvature_test

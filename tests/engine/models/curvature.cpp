#include "engine/models/viscosity/strain/curvature.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/viscous_block.h"

using namespace whorl;
using namespace whorl::test;

namespace curvature_test {

namespace {

/// Gradient G of the straight displacements that rotate a body by `angle` about z: from the current position forward, or up to the current
/// position.
Mat3 straight_turn(double angle, double dt, bool forward) {
    const double turned = forward ? angle : -angle, sign = forward ? 1 : -1;
    Mat3d R = Mat3d::Identity();
    R.topLeftCorner<2, 2>() << std::cos(turned), -std::sin(turned), std::sin(turned), std::cos(turned);
    return (sign / dt * (R - Mat3d::Identity())).cast<Real>();
}

}  // namespace

TEST_CASE("a rotating body strains at first order in the step without the curvature, not at all with it", "[viscosity]") {
    const double dt = 0.1;
    for (const double angle : {0.25, 0.1, 1e-3}) {
        const Mat3 G = straight_turn(angle, dt, true), D = Real(0.5) * (G + G.transpose());
        const Mat3 T = curvature_strain(straight_turn(angle, dt, false), static_cast<Real>(dt));
        const double shrinking = (1 - std::cos(angle)) / dt;
        CHECK(D(0, 0) == Approx(-shrinking).epsilon(1e-3));
        CHECK((D - T).norm() < 1e-3 * shrinking + 1e-6 * angle / dt);  // round-off of float in 1 - cos
    }
}

TEST_CASE("with the curvature a stretching at constant rate has its rate to second order in the step", "[viscosity]") {
    // Lengths grow by exp(rate dt) per step. At mid-step the rate is 2/dt tanh(rate dt/2).
    const Vec3d rate(2, -1, -1);
    const double dt = 0.05;
    const Mat3 before = Mat3d(((1 - (-dt * rate.array()).exp()) / dt).matrix().asDiagonal()).cast<Real>();
    const Mat3 after = Mat3d((((dt * rate.array()).exp() - 1) / dt).matrix().asDiagonal()).cast<Real>();
    const Mat3 D = after - curvature_strain(before, static_cast<Real>(dt));
    for (int a = 0; a < 3; ++a) {
        CHECK(std::abs(after(a, a) / rate[a] - 1) > 0.02);  // first order
        CHECK(D(a, a) == Approx(rate[a]).epsilon(1e-3));    // (rate dt)^2/12 = 8e-4
    }
}

TEST_CASE("the curvature never exceeds a fifth of the gradient", "[viscosity]") {
    for (const double angle : {0.3, 1.0, 3.0}) {
        Mat3 G = Mat3::Zero();
        G(0, 1) = static_cast<Real>(-1000 * angle), G(1, 0) = static_cast<Real>(1000 * angle);
        for (const Mat3& gradient : {G, Mat3(G.cwiseAbs())}) {
            CHECK(curvature_strain(gradient, Real(1e-3)).norm() <= Real(0.2001) * G.norm());
            CHECK(curvature_strain(gradient, Real(1e-3)).norm() > 0);
        }
    }
    CHECK(curvature_strain(Mat3::Zero(), Real(1e-3)) == Mat3::Zero());
}

TEST_CASE("the gradient before the forces is exact for linear fields, in a free block and at a no-slip wall", "[viscosity][boundary]") {
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

TEST_CASE("a rotating line and a rotating sheet of particles have the curvature of a body", "[viscosity]") {
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

#include "engine/models/viscosity/full_viscosity.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/geometry/shape.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/motion/motion.h"
#include "engine/models/viscosity/strain/curvature.h"
#include "engine/particles/sample.h"
#include "tests/support/coarse_difference.h"
#include "tests/support/viscous_block.h"

using namespace whorl;
using namespace whorl::test;

namespace full_viscosity_test {

namespace {

constexpr double d = 0.1;

ViscousOperator make_operator(TestWorld& w, Real dt, const ViscosityOptions& options = {}) {
    w.find_pairs();
    w.world.step.dt = dt;
    ViscousOperator A;
    World& c = w.world;
    A.set_up(options, c.context(), {c.fluid.column<field::role>()}, {c.fluid.column<field::viscosity>()});
    return A;
}

Stage full(ViscosityOptions options = {}) { return make_stage("viscosity", "viscosity", FullViscosity(options)); }

}  // namespace

TEST_CASE("the viscous operator is symmetric and positive, with walls, uneven particles and uneven viscosity", "[viscosity]") {
    for (bool correction : {true, false}) {
        TestWorld w = uneven_block(1000, Real(0.2));
        w.add_wall(1, +1, -0.32);
        ViscosityOptions options;
        options.correction = correction;
        const ViscousOperator A = make_operator(w, Real(0.01), options);
        CHECK(asymmetry(A) < 1e-6);
        const auto n = static_cast<std::size_t>(A.size());
        std::vector<Vec3> u(n), Au(n);
        for (std::size_t i = 0; i < n; ++i) u[i] = noise(static_cast<Index>(2 * i + 1));
        A.multiply(u, Au);
        CHECK(inner(Au, u) > inner(u, u));
    }
}

TEST_CASE("a rigid motion has no viscous force, even at a surface, on a line, in a sheet and for a pair", "[viscosity]") {
    for (const Vec3& half :
         {Vec3(0.4, 0.3, 0.3), Vec3(0.4, 0.05, 0.05), Vec3(0.3, 0.3, 0.05), Vec3(0.1, 0.05, 0.05), Vec3(0.05, 0.05, 0.05)}) {
        TestWorld w = uneven_block(1000, half.minCoeff() > 0.1 ? Real(0.2) : Real(0), {}, half);
        const ViscousOperator A = make_operator(w, Real(0.01));
        const auto x = w.column<field::position>();
        std::vector<Vec3> u(x.size()), Au(x.size());
        for (std::size_t i = 0; i < x.size(); ++i) u[i] = Vec3(1, 2, 3) + Vec3(-2, 1, 4).cross(x[i]);
        A.multiply(u, Au);
        double largest = 0;
        for (std::size_t i = 0; i < x.size(); ++i) largest = std::max<double>(largest, (Au[i] - u[i]).norm());
        CHECK(largest < 1e-4);  // round-off of float against forces of order K |grad u| = 1 to 7, times 4
    }
}

TEST_CASE("an affine flow dissipates 2 mu D:D of its volume to 1e-5, also at surfaces, in sheets and lines", "[viscosity]") {
    struct Body {
        Vec3 half;
        Mat3 gradient;  ///< only along directions that the particles span
    };
    Mat3 any, plane = Mat3::Zero(), line = Mat3::Zero();
    any << Real(0.1), 2, Real(-0.3), Real(0.5), Real(-0.7), Real(1.1), Real(-1.9), Real(0.2), Real(0.4);
    plane.topLeftCorner<2, 2>() << 1, 3, -2, Real(0.5);
    line(0, 0) = 2;
    for (const Body& body : {Body{Vec3(0.4, 0.3, 0.3), any}, Body{Vec3(0.3, 0.3, 0.05), plane}, Body{Vec3(0.4, 0.05, 0.05), line}}) {
        TestWorld w = uneven_block(1000, body.half.minCoeff() > 0.1 ? Real(0.2) : Real(0), {}, body.half);
        const Real dt = Real(0.01);
        const ViscousOperator A = make_operator(w, dt);
        const auto x = w.column<field::position>();
        const auto mu = w.column<field::viscosity>();
        std::vector<Vec3> u(x.size()), Au(x.size());
        for (std::size_t i = 0; i < x.size(); ++i) u[i] = body.gradient * x[i];
        A.multiply(u, Au);
        const Mat3d D = (body.gradient + body.gradient.transpose()).cast<double>() / 2;
        double exact = 0;
        for (const Real one : mu) exact += static_cast<double>(dt * one / w.world.step.rest_density) * 2 * D.squaredNorm();
        for (std::size_t i = 0; i < u.size(); ++i) Au[i] -= u[i];
        CHECK(inner(Au, u) == Approx(exact).epsilon(1e-5));
    }
}

TEST_CASE("a twisted rope dissipates 2 mu I within 5 % with 8 particles across, 3 % with 12", "[viscosity]") {
    // Dissipation per length, at a twist that grows by 1/(m s); I is the second moment of the cross-section about its diameter. The
    // outermost layer, where most of the torsion is, has half of its neighbours.
    for (const auto& [across, tolerance] : {std::pair{8, 0.05}, std::pair{12, 0.03}}) {
        INFO(across << " across");
        const double radius = across * d / 2, length = 30 * d, nu = 1;
        ShapeKeys keys;
        keys.kind = "cylinder";
        keys.from = Vec3d(-length / 2, 0, 0), keys.to = Vec3d(length / 2, 0, 0);
        keys.radius = radius;
        const Domain domain{Vec3::Constant(-2), Vec3::Constant(2), {}};
        const std::vector<Vec3> at = sample_shape(*make_shape(keys), Sampling::blue_noise, Real(d), domain, 1);
        TestWorld w(d, 2, domain);
        w.put(at);
        for (Real& mu : w.column<field::viscosity>()) mu = static_cast<Real>(1000 * nu);
        const Real dt = Real(0.01);
        const ViscousOperator A = make_operator(w, dt);
        std::vector<Vec3> u(at.size()), Au(at.size());
        for (std::size_t i = 0; i < u.size(); ++i) u[i] = Vec3(0, -at[i].x() * at[i].z(), at[i].x() * at[i].y());
        A.multiply(u, Au);
        for (std::size_t i = 0; i < u.size(); ++i) Au[i] -= u[i];
        const double second_moment = std::numbers::pi * std::pow(radius, 4) / 4;
        const double found = static_cast<double>(w.world.step.mass) * inner(Au, u) / static_cast<double>(dt);
        CHECK(found == Approx(2 * 1000 * nu * second_moment * length).epsilon(tolerance));
    }
}

TEST_CASE("the blocks of the preconditioner are the operator's own diagonal", "[viscosity]") {
    TestWorld w = uneven_block(1000, Real(0.2), {}, Vec3(0.2, 0.2, 0.2));
    w.add_wall(1, +1, -0.22);
    const ViscousOperator A = make_operator(w, Real(0.01));
    const auto n = static_cast<std::size_t>(A.size());
    double largest = 0;
    for (std::size_t i = 0; i < n; i += 5)
        for (int a = 0; a < 3; ++a) {
            std::vector<Vec3> unit(n, Vec3::Zero()), column(n), back(n);
            unit[i] = Vec3::Unit(a);
            A.multiply(unit, column);
            std::vector<Vec3> own(n, Vec3::Zero());
            own[i] = column[i];
            A.precondition(own, back);
            largest = std::max<double>(largest, (back[i] - Vec3::Unit(a)).norm());
        }
    CHECK(largest < 1e-4);
}

TEST_CASE("implicit viscosity keeps both momenta of a free body to 1e-5, even with a loose tolerance", "[viscosity]") {
    for (double mu : {1e-3, 1e3, 1e7}) {
        ViscosityOptions options;
        options.limits = {1e-2, 500};
        TestWorld w = uneven_block(mu, Real(0.2), {make_stage("gradient", "viscosity", VelocityGradient{}), full(options)});
        const auto x = w.column<field::position>();
        auto u = w.column<field::velocity>();
        double scale = 0;
        for (std::size_t i = 0; i < u.size(); ++i) {
            u[i] = noise(static_cast<Index>(i)) + Vec3(1, 0, 0) + Vec3(0, 0, 20).cross(x[i]);
            scale += w.world.step.mass * u[i].norm();
        }
        const Vec3d p = w.momentum(), L = w.angular_momentum();
        for (int s = 0; s < 5; ++s) w.step(0.01);
        CHECK((w.momentum() - p).norm() < 1e-5 * scale);
        CHECK((w.angular_momentum() - L).norm() < 1e-5 * scale * 0.4);  // 0.4 m: the body's half length
        CHECK(w.world.report.solves.at(0).report.converged);
    }
}

TEST_CASE("a solve with a viscosity that is not a number has not converged", "[viscosity]") {
    TestWorld w = uneven_block(1, Real(0.2), {make_stage("gradient", "viscosity", VelocityGradient{}), full()});
    w.column<field::viscosity>()[7] = std::numeric_limits<Real>::quiet_NaN();
    w.column<field::velocity>()[3] = Vec3(1, 0, 0);
    w.step(0.01);
    CHECK_FALSE(w.world.report.solves.at(0).report.converged);
}

TEST_CASE("one implicit step multiplies a shear wave by 1/(1 + nu k^2 dt) within 2 % at 32 particles a wave", "[viscosity]") {
    // u = sin(k y) e_x, periodic on all axes, from nu k^2 dt = 0.01 to 100.
    const double L = 32 * d, k = 2 * std::numbers::pi / L;
    for (double strength : {0.01, 1.0, 100.0}) {
        const double dt = 0.01, mu = 1000 * strength / (k * k * dt);
        ViscosityOptions options;
        options.limits.tolerance = 1e-5;
        TestWorld w(d, 2, Domain{Vec3::Zero(), Vec3(0.4, L, 0.4), {true, true, true}});
        w.use({full(options)});
        w.place(Vec3::Zero(), Vec3(0.4, L, 0.4), mu, [&](const Vec3& x) { return Vec3(std::sin(k * x.y()), 0, 0); });
        w.step(dt);
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        double amplitude = 0;
        for (std::size_t i = 0; i < x.size(); ++i) amplitude += 2 * u[i].x() * std::sin(k * x[i].y()) / static_cast<double>(x.size());
        CHECK(amplitude == Approx(1 / (1 + strength)).epsilon(0.02));
    }
}

TEST_CASE("the viscosity's coarse matrix is R^T A R to 1e-5, with walls, thin parts and fixed particles", "[viscosity]") {
    for (const Vec3& half : {Vec3(0.4, 0.3, 0.3), Vec3(0.6, 0.1, 0.05)}) {
        TestWorld w = uneven_block(1000, half.z() > 0.1 ? Real(0.2) : Real(0), {}, half);
        w.add_wall(1, +1, -half.y() - 0.02);
        w.column<field::role>()[5] = -1;
        const ViscousOperator A = make_operator(w, Real(0.01));
        const auto x = w.column<field::position>();
        std::vector<std::int32_t> group(x.size());
        const int groups = form_aggregates(w.world.fluid_pairs, x, w.column<field::role>(), w.world.step.domain, Real(0.2), 20, group);
        CHECK(groups > 1);
        CHECK(group[5] == 0);
        RigidAggregates R;
        R.place(x, w.column<field::role>(), group, groups, w.world.step.domain, Real(0.1));
        const SymmetricBlocks coarse = A.coarse_matrix(R);
        const CoarseDifference found =
            coarse_difference([&](Span<const Vec3> u, Span<Vec3> Au) { A.multiply(u, Au); }, R, coarse, x.size());
        CHECK(found.difference < 1e-5 * found.largest + 1.1e-3);  // a rotation that moves nothing is given 1e-3
    }
}

TEST_CASE("the coarse level moves particles, not free bodies") {
    const std::vector<Vec3> x{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    const std::vector<std::int16_t> role(4, 0);
    const std::vector<std::int32_t> group(4, 1);
    CoarseLevel coarse;
    for (const std::size_t n : {std::size_t(4), std::size_t(2)})
        coarse.place(std::span(x).first(n), std::span(role).first(n), std::span(group).first(n), 1, {}, 1);
    SymmetricBlocks Ac(1);
    Ac.add(0, 0, SymmetricBlocks::Block::Identity());
    coarse.factor(Ac);
    const std::vector<Vec3> r(4, Vec3(Vec3::Ones()));
    std::vector<Vec3> z(4, Vec3(Vec3::Zero()));
    coarse.add(r, z);
    CHECK(z[0].norm() > 0);
    CHECK(z[2] == Vec3(Vec3::Zero()));
    CHECK(z[3] == Vec3(Vec3::Zero()));
}

TEST_CASE("the coarse level halves the iterations of a stiff free body and keeps its momenta to 1e-5", "[viscosity]") {
    // A bar of 40 x 6 x 6 with nu dt/d^2 = 1000, bent by its initial velocity.
    std::array<int, 2> iterations{};
    for (int coarse : {0, 1}) {
        ViscosityOptions options;
        if (!coarse) options.preconditioner = ViscousPreconditioner::block_jacobi;
        TestWorld w(0.1, 2, Domain{Vec3(-4, -4, -4), Vec3(4, 4, 4), {}});
        w.use({full(options)});
        w.place(Vec3(Real(-2), Real(-0.3), Real(-0.3)), Vec3(Real(2), Real(0.3), Real(0.3)), 1e6,
                [](const Vec3& x) { return Vec3(0, std::sin(2 * x.x()), Real(0.5) * x.x() * x.x()); });
        double scale = 0;
        for (const Vec3& u : w.column<field::velocity>()) scale += w.world.step.mass * u.norm();
        const Vec3d p = w.momentum(), L = w.angular_momentum();
        w.step(0.01);
        CHECK(w.world.report.solves.at(0).report.converged);
        CHECK((w.momentum() - p).norm() < 1e-5 * scale);
        CHECK((w.angular_momentum() - L).norm() < 1e-5 * scale * 2);  // 2 m: the body's half length
        iterations[coarse] = w.world.report.solves.at(0).report.iterations;
    }
    CHECK(2 * iterations[1] < iterations[0]);  // norms differ: at equal residuals the diagonal has the larger error
}

}  // namespace full_viscosity_test

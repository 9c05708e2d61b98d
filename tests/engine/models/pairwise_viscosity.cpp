#include <catch2/catch.hpp>
#include <numbers>

#include "engine/models/viscosity/pairwise.h"
#include "tests/support/viscous_block.h"

using namespace whorl;
using namespace whorl::test;

namespace {

PairwiseOperator make_operator(TestWorld& w, Real dt) {
    w.find_pairs();
    w.world.step.dt = dt;
    PairwiseOperator A;
    const World& c = w.world;
    A.set_up(c.fluid_pairs, c.solid_pairs, c.solids, c.solid_particles, c.step, {c.fluid.column<field::role>()},
             {c.fluid.column<field::viscosity>()});
    return A;
}

Stage pairwise(double tolerance) {
    PairwiseViscosityOptions options;
    options.limits.tolerance = tolerance;
    return make_stage("viscosity", "viscosity", PairwiseViscosity(options));
}

}  // namespace

TEST_CASE("the pairwise operator is symmetric and positive, with walls, uneven particles and uneven viscosity", "[viscosity]") {
    TestWorld w = uneven_block(1000, Real(0.2));
    w.add_wall(1, +1, -0.32);
    const PairwiseOperator A = make_operator(w, Real(0.01));
    CHECK(asymmetry(A) < 1e-6);
    std::vector<Vec3> u(A.size()), Au(u.size());
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = noise(static_cast<Index>(2 * i + 1));
    A.multiply(u, Au);
    CHECK(inner(Au, u) > inner(u, u));
}

TEST_CASE("pairwise viscosity keeps momentum and angular momentum of a free body to 1e-5, even with a loose tolerance", "[viscosity]") {
    for (double mu : {1e-3, 1e3, 1e7}) {
        TestWorld w = uneven_block(mu, Real(0.2), {pairwise(1e-2)});
        auto u = w.column<field::velocity>();
        double scale = 0;
        for (std::size_t i = 0; i < u.size(); ++i) {
            u[i] = noise(static_cast<Index>(i)) + Vec3(1, 0, 0);
            scale += w.world.step.mass * u[i].norm();
        }
        const Vec3d p = w.momentum(), L = w.angular_momentum();
        for (int s = 0; s < 5; ++s) w.step(0.01);
        CHECK((w.momentum() - p).norm() < 1e-5 * scale);
        CHECK((w.angular_momentum() - L).norm() < 1e-5 * scale * 0.4);  // 0.4 m: the body's half length
        CHECK(w.world.report.solves.at(0).report.converged);
    }
}

TEST_CASE("one pairwise step multiplies a shear wave by 1/(1 + nu k^2 dt), with nu as stiff as the lattice makes it, within 2 %",
          "[viscosity]") {
    for (double support : {2.0, 4.0}) {
        const double d = 0.1, L = 32 * d, k = 2 * std::numbers::pi / L, width = 2 * support * d, dt = 0.01;
        const double shear = pairwise_lattice_stiffness(KernelKind::cubic, support * d, d).shear;
        CHECK(shear == Approx(support < 3 ? 0.70 : 0.99).margin(0.01));
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(width), Real(L), Real(width)), {true, true, true}});
        w.use({pairwise(1e-5)});
        w.place(Vec3::Zero(), Vec3(Real(width), Real(L), Real(width)), 1000 / (k * k * dt),
                [&](const Vec3& x) { return Vec3(Real(std::sin(k * x.y())), 0, 0); });
        w.step(dt);
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        double amplitude = 0;
        for (std::size_t i = 0; i < x.size(); ++i) amplitude += 2 * u[i].x() * std::sin(k * x[i].y()) / static_cast<double>(x.size());
        CHECK(amplitude == Approx(1 / (1 + shear)).epsilon(0.02));
    }
}

#include "engine/models/viscosity/explicit_viscosity.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "engine/models/boundary/wall.h"
#include "engine/models/motion/motion.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace {

/// A drop of fluid in free space with uneven density and viscosity, so that no symmetry hides an error.
TestWorld uneven_blob(std::vector<Stage> stages) {
    TestWorld w(0.1, 2, Domain{Vec3(-2, -2, -2), Vec3(2, 2, 2), {}});
    w.use(std::move(stages));
    w.place(Vec3(-0.4, -0.3, -0.3), Vec3(0.4, 0.3, 0.3), 1,
            [](const Vec3& x) { return Vec3(std::sin(9 * x.y()), 1 + x.x() * x.z(), std::cos(7 * x.x())); });
    auto x = w.column<field::position>();
    auto mu = w.column<field::viscosity>();
    for (std::size_t i = 0; i < x.size(); ++i) {
        mu[i] = 1 + Real(i % 7);
        x[i] += Real(0.02) * Vec3(std::sin(Real(3 * i)), std::sin(Real(5 * i)), std::sin(Real(7 * i)));
    }
    return w;
}

}  // namespace

TEST_CASE("XSPH smooths and keeps the momentum to 1e-6 of the sum of |m u|", "[viscosity]") {
    TestWorld w = uneven_blob({make_stage("density", "density", Density{}), make_stage("xsph", "viscosity", XsphViscosity{Real(0.2)})});
    const Vec3d before = w.momentum();
    double scale = 0, rough = 0, smooth = 0;
    for (const Vec3& u : w.column<field::velocity>()) scale += w.world.step.mass * u.norm(), rough += u.squaredNorm();
    w.step(1);
    for (const Vec3& u : w.column<field::velocity>()) smooth += u.squaredNorm();
    CHECK((w.momentum() - before).norm() < 1e-6 * scale);
    CHECK(smooth < rough);
}

TEST_CASE("explicit viscosity keeps momentum to 1e-6, also with uneven density and viscosity", "[viscosity]") {
    for (bool monaghan : {false, true}) {
        TestWorld w =
            uneven_blob({make_stage("density", "density", Density{}), make_stage("gravity", "move", Gravity{}),
                         make_stage("viscosity", "viscosity",
                                    ExplicitViscosity{{.laplacian = monaghan ? LaplacianForm::monaghan : LaplacianForm::brookshaw}}),
                         make_stage("kick", "move", Kick{})});
        const Vec3d before = w.momentum();
        double scale = 0;
        for (const Vec3& u : w.column<field::velocity>()) scale += w.world.step.mass * u.norm();
        w.step(0.05);
        CHECK((w.momentum() - before).norm() < 1e-6 * scale);
    }
}

TEST_CASE("uniform shear along a no-slip wall has no viscous force, not even next to the wall", "[viscosity][boundary]") {
    // u = y e_x above a wall at y = 0: Lap u = 0. Lattice and shear continue in the wall: zero to round-off.
    const Real d = Real(0.1);
    for (int dimensions : {3, 2}) {
        INFO(dimensions << " dimensions");
        const Vec3 corner(1, 1, dimensions == 3 ? 1 : 0);
        TestWorld w(d, 2, Domain{Vec3(0, 0, 0), corner, {true, false, dimensions == 3}});
        const Real factor = continued_lattice_factor(w.world.step.kernel, 2 * d, d);
        w.use({make_stage("density", "density", Density{factor}), make_stage("gravity", "move", Gravity{}),
               make_stage("viscosity", "viscosity", ExplicitViscosity{{.solid_factor = factor}})});
        w.add_wall(1, +1, 0);
        w.place(Vec3(0, 0, 0), corner, 1, [](const Vec3& x) { return Vec3(x.y(), 0, 0); });
        w.step(0);
        const auto x = w.column<field::position>();
        const auto a = w.column<field::acceleration>();
        const auto rho = w.column<field::density>();
        double largest = 0, densest = 0;
        for (std::size_t i = 0; i < x.size(); ++i)
            if (x[i].y() < 0.75) {
                largest = std::max<double>(largest, a[i].norm());
                densest = std::max<double>(densest, std::abs(rho[i] / 1000 - 1));
            }
        // Relative to mu u'/(rho d), the force of one layer on the next. In 2D the fluid's lattice sum is 1.0009 rho_0: fluid neighbours
        // have that much less weight than wall neighbours.
        CHECK(largest < (dimensions == 3 ? 1e-4 : 1e-3) / (1000 * d));
        CHECK(densest < 1e-3);  // the lattice sum itself is 1.0004 rho_0, in 2D 1.0009
    }
}

TEST_CASE("XSPH and both explicit Laplacians equal the sums of the notes to 1e-5", "[viscosity]") {
    constexpr Real alpha = Real(0.002), dt = Real(0.5);
    enum class Form { xsph, brookshaw, monaghan };
    for (const Form form : {Form::xsph, Form::brookshaw, Form::monaghan}) {
        INFO("form " << static_cast<int>(form));
        std::vector<Stage> stages{make_stage("density", "density", Density{}), make_stage("gravity", "move", Gravity{})};
        if (form != Form::xsph)
            stages.push_back(
                make_stage("viscosity", "viscosity",
                           ExplicitViscosity{{.laplacian = form == Form::monaghan ? LaplacianForm::monaghan : LaplacianForm::brookshaw}}));
        stages.push_back(make_stage("kick", "move", Kick{}));
        if (form == Form::xsph) stages.push_back(make_stage("viscosity", "viscosity", XsphViscosity{alpha}));
        TestWorld w = uneven_blob(std::move(stages));
        const auto u = w.column<field::velocity>();
        const std::vector<Vec3> before(u.begin(), u.end());
        w.step(dt);
        const auto x = w.column<field::position>();
        const auto rho = w.column<field::density>(), mu = w.column<field::viscosity>();
        const StepContext& step = w.world.step;
        const CubicKernel W(step.support);
        // The factors that correct the lattice's sums (docs/physics.md 4).
        const double factor = form == Form::brookshaw ? 1 / lattice_gradient(step.kernel, step.support, step.spacing)
                                                      : along_pairs_factor(step.kernel, step.support, step.spacing);
        double apart = 0, most = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            Vec3d change = Vec3d::Zero();
            for (std::size_t j = 0; j < x.size(); ++j) {
                const Vec3d r = (x[i] - x[j]).cast<double>(), u_ij = (before[i] - before[j]).cast<double>();
                const double distance = r.norm(), m = step.mass, h = static_cast<double>(step.support) / 2;
                if (i == j || !(distance < 2 * h)) continue;
                const Vec3d gradient = static_cast<double>(W.derivative(static_cast<Real>(distance))) / distance * r;
                const double mu_ij = 2.0 * mu[i] * mu[j] / static_cast<double>(mu[i] + mu[j]),
                             of_pair = m * mu_ij * factor / rho[i] / rho[j];
                if (form == Form::xsph)
                    change -= static_cast<double>(alpha) * 2 * m / static_cast<double>(rho[i] + rho[j]) *
                              static_cast<double>(W.value(static_cast<Real>(distance))) * u_ij;
                if (form == Form::brookshaw) change -= static_cast<double>(dt) * of_pair * 2 * gradient.norm() / distance * u_ij;
                if (form == Form::monaghan)
                    change += static_cast<double>(dt) * of_pair * 10 * u_ij.dot(r) / (distance * distance + 0.01 * h * h) * gradient;
            }
            most = std::max(most, change.norm());
            apart = std::max(apart, ((u[i] - before[i]).cast<double>() - change).norm());
        }
        // XSPH changes velocities of 1 by some 1e-3, of which 1e-4 is round-off.
        CHECK(apart < (form == Form::xsph ? 2e-4 : 1e-5) * most);
    }
}

/// The weakly compressible pressure's forces, one application each.
#include "engine/models/pressure/wcsph.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/random.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/motion/motion.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace wcsph_test {

namespace {

constexpr double d = 0.01, g = 9.81, rho_0 = 1000;

/// Sets the pressure, in place of Tait's equation.
struct GivenPressure {
    std::function<double(const Vec3&)> value;
    void operator()(Read<field::position> x, Write<field::pressure> p) const {
        for (Index i = 0; i < p.size(); ++i) p[i] = static_cast<Real>(value(x[i]));
    }
};

/// A free ball of jittered particles with the velocities u(x) [m/s]; a step of dt = 0 leaves the accelerations of the stages.
TestWorld ball(const PressureOptions& options, const std::function<Vec3(const Vec3&)>& u) {
    TestWorld w(d, 2, Domain{Vec3(-1, -1, -1), Vec3(1, 1, 1), {}});
    std::vector<Stage> stages{make_stage("density", "density", Density{}),
                              make_stage("given", "pressure", GivenPressure{[](const Vec3&) { return 1e5; }}),
                              make_stage("gravity", "move", Gravity{})};
    if (options.sound_damping > 0) stages.insert(stages.begin() + 2, make_stage("sound damping", "pressure", SoundDamping{options}));
    stages.push_back(make_stage("pressure", "pressure", PressureAcceleration{options}));
    if (options.artificial_viscosity > 0) stages.push_back(make_stage("artificial viscosity", "pressure", ArtificialViscosity{options}));
    w.use(std::move(stages));
    w.place(Vec3::Constant(Real(-4 * d)), Vec3::Constant(Real(4 * d)));
    RandomNumbers random(7);
    const auto x = w.column<field::position>();
    for (Vec3& one : x)
        for (int a = 0; a < 3; ++a) one[a] += static_cast<Real>(0.2 * d * (2 * random() - 1));
    const auto v = w.column<field::velocity>();
    for (std::size_t i = 0; i < x.size(); ++i) v[i] = u(x[i]);
    w.step(0);
    return w;
}

/// Contribution of the dampers (the other forces do not depend on velocities), sums over the particles.
struct Effect {
    Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();
    double power = 0, size = 0;  ///< W; sum |m a| [N]
};

Effect effect_of(PressureOptions dampers, const std::function<Vec3(const Vec3&)>& u) {
    dampers.sound_speed = 10;
    PressureOptions bare = dampers;
    bare.sound_damping = 0, bare.artificial_viscosity = 0;
    TestWorld with = ball(dampers, u), without = ball(bare, u);
    const auto x = with.column<field::position>(), v = with.column<field::velocity>();
    const auto a = with.column<field::acceleration>(), b = without.column<field::acceleration>();
    Effect e;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3d f = static_cast<double>(with.world.step.mass) * (a[i].cast<double>() - b[i].cast<double>());
        e.force += f;
        e.torque += x[i].cast<double>().cross(f);
        e.power += f.dot(v[i].cast<double>());
        e.size += f.norm();
    }
    return e;
}

PressureOptions damper(bool sound) {
    PressureOptions options;
    options.sound_damping = sound ? 1 : 0, options.artificial_viscosity = sound ? 0 : 1;
    return options;
}

}  // namespace

TEST_CASE("sound damping and artificial viscosity dissipate energy and keep both momenta", "[wcsph]") {
    for (const bool sound : {true, false}) {
        INFO((sound ? "sound damping" : "artificial viscosity"));
        RandomNumbers random(3);
        const auto component = [&] { return static_cast<Real>(random() - 0.5); };
        const Effect e = effect_of(damper(sound), [&](const Vec3&) { return Vec3(component(), component(), component()); });
        CHECK(e.power < -1e-3 * e.size);
        // Differences of two sums in float: each acceleration carries round-off of its pressure part.
        CHECK(e.force.norm() < 1e-4 * e.size);
        CHECK(e.torque.norm() < 1e-4 * e.size * 4 * d);
    }
}

TEST_CASE("a rigidly moving ball has no sound damping and no artificial viscosity", "[wcsph]") {
    const Vec3 flight(1, 2, 3), turn(4, -5, 6);
    for (const bool sound : {true, false}) {
        const Effect rigid = effect_of(damper(sound), [&](const Vec3& x) { return Vec3(flight + turn.cross(x)); });
        const Effect growing = effect_of(damper(sound), [&](const Vec3& x) { return Vec3(8 * x); });
        CHECK(rigid.size < 1e-3 * growing.size);
    }
}

TEST_CASE("water at a vertical wall has the same pressure gradient as far from the wall", "[wcsph]") {
    const double H = 12 * d;
    PressureOptions options;
    options.sound_speed = 10;
    options.solid_factor = continued_lattice_factor(KernelKind::cubic, Real(2 * d), Real(d));
    TestWorld w(d, 2, Domain{Vec3::Zero(), Vec3(Real(12 * d), Real(H), Real(6 * d)), {false, false, true}});
    w.use({make_stage("density", "density", Density{options.solid_factor}),
           make_stage("given", "pressure", GivenPressure{[&](const Vec3& x) { return rho_0 * g * (H - x.y()); }}),
           make_stage("gravity", "move", Gravity{}), make_stage("pressure", "pressure", PressureAcceleration{options})});
    w.world.step.gravity = Vec3(0, Real(-g), 0);
    w.add_wall(0, +1, 0);
    w.place(Vec3::Zero(), Vec3(Real(12 * d), Real(H), Real(6 * d)));
    w.step(0);
    const auto x = w.column<field::position>(), a = w.column<field::acceleration>();
    double at_wall = 0, far = 0, sideways = 0;
    int count_at_wall = 0, count_far = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (std::abs(x[i].y() - H / 2) > 2 * d) continue;
        if (x[i].x() < d) at_wall += a[i].y() + g, sideways += a[i].x(), ++count_at_wall;
        if (std::abs(x[i].x() - 6 * d) < d) far += a[i].y() + g, ++count_far;
    }
    // A lattice has 1.02 times the gradient of a linear pressure. The wall's layer replaces two lattice layers, except for the force of the
    // second along the wall.
    CHECK(far / count_far == Approx(g * lattice_gradient(KernelKind::cubic, Real(2 * d), Real(d))).epsilon(2e-3));
    CHECK(at_wall / count_at_wall == Approx(far / count_far).epsilon(0.05));
    CHECK(std::abs(sideways / count_at_wall) < 0.05 * g);
}

TEST_CASE("Tait's pressure is c^2 rho_0/gamma ((rho/rho_0)^gamma - 1) + p0, and 0 if that is negative", "[wcsph]") {
    TestWorld w(d, 2, Domain{});
    PressureOptions options;
    options.sound_speed = 20;
    for (const double gamma : {1.0, 2.0, 7.0})
        for (const double p0 : {0.0, 5000.0}) {
            INFO("gamma " << gamma << ", p0 " << p0);
            options.gamma = gamma, options.background_pressure = p0;
            w.use({make_stage("tait", "pressure", TaitPressure{options})});
            w.world.fluid.declare(field_info<field::density>(), true);
            w.world.fluid.resize(5);
            const double ratio[5] = {0.5, 0.99, 1, 1.01, 1.5};
            for (int k = 0; k < 5; ++k) w.column<field::density>()[k] = static_cast<Real>(ratio[k] * rho_0);
            w.stages[0].run(w.world);
            const double stiffness = 20 * 20 * rho_0 / gamma;
            for (int k = 0; k < 5; ++k) {
                const double exact = std::max(0.0, stiffness * (std::pow(ratio[k], gamma) - 1) + p0);
                // Single precision: the difference from 1 carries round-off of gamma/2 1e-7.
                CHECK(static_cast<double>(w.column<field::pressure>()[k]) == Approx(exact).epsilon(1e-6).margin(1e-6 * gamma * stiffness));
            }
        }
}

TEST_CASE("both pressure gradients equal the notes' sums to 1e-5 and are exact for their fields", "[wcsph]") {
    const auto place = [](bool difference, bool jitter, const std::function<double(const Vec3&)>& pressure) {
        PressureOptions options;
        options.gradient = difference ? GradientForm::difference : GradientForm::symmetric;
        TestWorld w(d, 2, Domain{Vec3::Constant(-1), Vec3::Constant(1), {}});
        w.use({make_stage("density", "density", Density{}), make_stage("given", "pressure", GivenPressure{pressure}),
               make_stage("gravity", "move", Gravity{}), make_stage("pressure", "pressure", PressureAcceleration{options})});
        w.place(Vec3::Constant(Real(-4 * d)), Vec3::Constant(Real(4 * d)));
        RandomNumbers random(9);
        if (jitter)
            for (Vec3& x : w.column<field::position>())
                for (int a = 0; a < 3; ++a) x[a] += static_cast<Real>(0.3 * d * (2 * random() - 1));
        w.step(0);
        return w;
    };
    const Vec3 slope(1000, -2000, 3000);
    for (const bool difference : {false, true}) {
        INFO((difference ? "difference" : "symmetric"));
        TestWorld w = place(difference, true, [&](const Vec3& x) { return 1000 + static_cast<double>(slope.dot(x)); });
        const auto x = w.column<field::position>(), a = w.column<field::acceleration>();
        const auto rho = w.column<field::density>(), p = w.column<field::pressure>();
        const CubicKernel W(w.world.step.support);
        double apart = 0, most = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            Vec3d printed = Vec3d::Zero();
            for (std::size_t j = 0; j < x.size(); ++j) {
                const Vec3 r = x[i] - x[j];
                if (i == j || !(r.norm() < w.world.step.support)) continue;
                const double m = w.world.step.mass, p_i = p[i], p_j = p[j], rho_i = rho[i], rho_j = rho[j];
                const double push = difference ? m / rho_j * (p_j - p_i) : rho_i * m * (p_i / (rho_i * rho_i) + p_j / (rho_j * rho_j));
                printed += push * static_cast<double>(W.derivative(r.norm()) / r.norm()) * r.cast<double>();
            }
            most = std::max(most, printed.norm());
            apart = std::max(apart, (static_cast<double>(-rho[i]) * a[i].cast<double>() - printed).norm());
        }
        CHECK(apart < 1e-5 * most);
    }
    // Constant pressure, uneven particles, a free surface: the difference form gives zero.
    TestWorld constant = place(true, true, [](const Vec3&) { return 1e5; });
    for (const Vec3& a : constant.column<field::acceleration>()) CHECK(a.norm() == 0);
    // A linear pressure, on a lattice, away from the surface: the slope, times the lattice sum over 3 of the kernel (docs/physics.md 4).
    const Real sum = lattice_gradient(KernelKind::cubic, Real(2 * d), Real(d));
    for (const bool difference : {false, true}) {
        INFO((difference ? "difference" : "symmetric"));
        TestWorld linear = place(difference, false, [&](const Vec3& x) { return 1000 + static_cast<double>(slope.dot(x)); });
        for (std::size_t i = 0; i < linear.column<field::position>().size(); ++i) {
            if (linear.column<field::position>()[i].cwiseAbs().maxCoeff() > Real(d)) continue;
            const Vec3 gradient = -linear.column<field::density>()[i] * linear.column<field::acceleration>()[i];
            // The density on this lattice is 1.0004 times that at rest.
            CHECK((gradient - sum * slope).norm() < 1e-3 * slope.norm());
        }
    }
}

}  // namespace wcsph_test

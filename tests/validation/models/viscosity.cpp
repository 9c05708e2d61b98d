/// Viscous models against exact solutions (no pressure: the flows are parallel or decay before particles have moved far).
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/models/boundary/wall.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/poisson.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

using namespace whorl;
using namespace whorl::test;

namespace viscosity_test {

namespace {

enum class Form { brookshaw, monaghan, full };
constexpr Form all_forms[] = {Form::brookshaw, Form::monaghan, Form::full};

bool is_implicit(Form form) { return form == Form::full; }

/// Gravity, kick and the viscosity of that form, without motion and without pressure: the exact flow has none to speak of.
std::vector<Stage> viscous_step_of(Form form, Real solid_factor, double tolerance = 1e-5) {
    std::vector<Stage> stages{make_stage("density", "density", Density{solid_factor}), make_stage("gravity", "move", Gravity{})};
    if (!is_implicit(form))
        stages.push_back(make_stage("viscosity", "viscosity", ExplicitViscosity{{form == Form::monaghan, solid_factor}}));
    stages.push_back(make_stage("kick", "move", Kick{}));
    if (form == Form::full) {
        FullViscosityOptions options;
        options.solid_factor = solid_factor;
        options.limits.tolerance = tolerance;
        stages.push_back(make_stage("viscosity", "viscosity", FullViscosity(options)));
    }
    return stages;
}

const char* name(Form form) { return form == Form::brookshaw ? "brookshaw" : form == Form::monaghan ? "monaghan" : "full"; }

/// Kernel radius over spacing. Forces along the pairs take their isotropy from the neighbours' fourth moments: on a lattice with R = 2 d
/// they make shear 0.70 and stretching 1.45 times as stiff as they are; they need more neighbours than the others.
double support_of(Form form) { return form == Form::monaghan ? 4 : 2; }

/// Calls test(form, dimensions, depth of the box along z [m]) for all forms, in space and in the plane.
template <class F>
void in_space_and_plane(double depth, const F& test) {
    for (Form form : all_forms)
        for (int dimensions : {3, 2}) {
            INFO(name(form) << " in " << dimensions << " dimensions");
            test(form, dimensions, dimensions == 3 ? depth : 0);
        }
}

/// Amplitude of (sin kx cos ky, -cos kx sin ky) in the flow.
double vortex_amplitude(TestWorld& w, double k) {
    const auto x = w.column<field::position>();
    const auto u = w.column<field::velocity>();
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        sum +=
            2 * (u[i].x() * std::sin(k * x[i].x()) * std::cos(k * x[i].y()) - u[i].y() * std::cos(k * x[i].x()) * std::sin(k * x[i].y()));
    return sum / static_cast<double>(x.size());
}

}  // namespace

TEST_CASE("a Taylor-Green vortex decays as exp(-2 nu k^2 t) within 2 % of its rate, 32 particles a wave, explicit and full",
          "[validation][viscosity]") {
    const double L = 1, d = L / 32, k = 2 * std::numbers::pi / L, nu = 1;
    in_space_and_plane(8 * d, [&](Form form, int dimensions, double depth) {
        const double support = support_of(form);
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(L), Real(L), Real(depth)), {true, true, dimensions == 3}});
        w.use(viscous_step_of(form, 1));
        w.world.step.gravity.setZero();
        w.place(Vec3::Zero(), Vec3(Real(L), Real(L), Real(depth)), 1000 * nu, [&](const Vec3& x) {
            return Vec3(Real(std::sin(k * x.x()) * std::cos(k * x.y())), Real(-std::cos(k * x.x()) * std::sin(k * x.y())), 0);
        });
        // To 1/e. The implicit step is first order in time: its own factor 1/(1 + 2 nu k^2 dt) a step is what it is held to.
        const double end = 1 / (2 * nu * k * k);
        const int steps = is_implicit(form) ? 20 : static_cast<int>(std::ceil(end / viscous_step(support * d, nu)));
        const double dt = end / steps;
        const double start = vortex_amplitude(w, k);
        for (int s = 0; s < steps; ++s) w.step(dt);
        const double rate = -std::log(vortex_amplitude(w, k) / start);
        const double exact = is_implicit(form) ? steps * std::log(1 + 2 * nu * k * k * dt) : -steps * std::log(1 - 2 * nu * k * k * dt);
        CHECK(rate == Approx(exact).epsilon(0.02));
    });
}

TEST_CASE("plane Poiseuille flow between walls at rest reaches its parabola within 2 %, 24 particles across",
          "[validation][viscosity][boundary]") {
    const double H = 1, d = H / 24, nu = 1, g = 8;  // largest speed g H^2/(8 nu) = 1
    in_space_and_plane(8 * d, [&](Form form, int dimensions, double depth) {
        const double support = support_of(form), width = 8 * d;
        const Real factor = continued_lattice_factor({KernelKind::cubic, dimensions}, Real(support * d), Real(d));
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(width), Real(H), Real(depth)), {true, false, dimensions == 3}});
        w.use(viscous_step_of(form, factor));
        w.world.step.gravity = Vec3(Real(g), 0, 0);
        w.add_wall(1, +1, 0);
        w.add_wall(1, -1, H);
        w.place(Vec3::Zero(), Vec3(Real(width), Real(H), Real(depth)), 1000 * nu);
        const double dt = is_implicit(form) ? 0.02 : 0.9 * viscous_step(support * d, nu);
        for (int s = 0; s < static_cast<int>(0.6 / dt); ++s) w.step(dt);  // the slowest mode has decayed by exp(-pi^2 0.6) = 0.3 %
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        double worst = 0;
        for (std::size_t i = 0; i < x.size(); ++i) worst = std::max(worst, std::abs(u[i].x() - g / (2 * nu) * x[i].y() * (H - x[i].y())));
        CHECK(worst < (dimensions == 2 ? 0.022 : 0.02));  // the fourth moments of a square lattice are less round
    });
}

TEST_CASE("plane Couette flow between a wall at rest and one that moves stays straight within 2 %, 16 particles across",
          "[validation][viscosity][boundary]") {
    // From the exact flow, for nu t/H^2 = 0.5: what a discrete steady state differs by has come up to 1 - exp(-pi^2/2) = 99 %.
    const double H = 1, d = H / 16, nu = 1;
    in_space_and_plane(8 * d, [&](Form form, int dimensions, double depth) {
        const double support = support_of(form), width = 8 * d;
        const Real factor = continued_lattice_factor({KernelKind::cubic, dimensions}, Real(support * d), Real(d));
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(width), Real(H), Real(depth)), {true, false, dimensions == 3}});
        w.use(viscous_step_of(form, factor));
        w.world.step.gravity.setZero();
        w.add_wall(1, +1, 0);
        w.add_wall(1, -1, H);
        w.world.solids.all[1].pose.velocity = Vec3(1, 0, 0);
        SolidParticles& layer = w.world.solid_particles;
        for (Index s = 0; s < layer.size(); ++s)
            if (layer.solid[s] == 1) layer.velocity[s] = Vec3(1, 0, 0);
        w.place(Vec3::Zero(), Vec3(Real(width), Real(H), Real(depth)), 1000 * nu, [](const Vec3& x) { return Vec3(x.y(), 0, 0); });
        const double dt = is_implicit(form) ? 0.02 : 0.9 * viscous_step(support * d, nu);
        for (int s = 0; s < static_cast<int>(0.5 / dt); ++s) w.step(dt);
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        double worst = 0;
        for (std::size_t i = 0; i < x.size(); ++i) worst = std::max<double>(worst, std::abs(u[i].x() - x[i].y()));
        CHECK(worst < 0.02);
    });
}

TEST_CASE("a film on an incline keeps its half parabola within 2 %, 16 particles deep, with the forms whose free surface bears no shear",
          "[validation][viscosity][boundary]") {
    // u = g (2 H y - y^2)/(2 nu), from the exact flow, for nu t/H^2 = 1: what the steady state differs by has come up to 1 - exp(-pi^2/4) =
    // 92 %.
    const double H = 1, d = H / 16, nu = 1, g = 2;  // largest speed g H^2/(2 nu) = 1
    in_space_and_plane(8 * d, [&](Form form, int dimensions, double depth) {
        const double support = support_of(form), width = 8 * d;
        const Real factor = continued_lattice_factor({KernelKind::cubic, dimensions}, Real(support * d), Real(d));
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(width), Real(2 * H), Real(depth)), {true, false, dimensions == 3}});
        w.use(viscous_step_of(form, factor));
        w.world.step.gravity = Vec3(Real(g), 0, 0);
        w.add_wall(1, +1, 0);
        w.place(Vec3::Zero(), Vec3(Real(width), Real(H), Real(depth)), 1000 * nu,
                [&](const Vec3& x) { return Vec3(Real(g / (2 * nu) * x.y() * (2 * H - x.y())), 0, 0); });
        const double dt = is_implicit(form) ? 0.02 : 0.9 * viscous_step(support * d, nu);
        for (int s = 0; s < static_cast<int>(1 / dt); ++s) w.step(dt);
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        double worst = 0;
        for (std::size_t i = 0; i < x.size(); ++i)
            worst = std::max<double>(worst, std::abs(u[i].x() - g / (2 * nu) * x[i].y() * (2 * H - x[i].y())));
        CHECK(worst < 0.02);
    });
}

TEST_CASE("a free body that turns keeps its angular momentum within 0.1 % and its energy within 1 % over two turns, with nu dt/d^2 = 10",
          "[validation][viscosity]") {
    // A cube of 8^3; no pressure: a rigid rotation needs a centripetal force, so the body is turned, not moved.
    const double d = 0.1;
    TestWorld w(d, 2, Domain{Vec3(-4, -4, -4), Vec3(4, 4, 4), {}});
    w.use({viscous_step_of(Form::full, 1, 1e-4).back()});
    w.place(Vec3(-0.4, -0.4, -0.4), Vec3(0.4, 0.4, 0.4), 1e4,
            [](const Vec3& x) { return Vec3(Vec3(-x.y(), x.x(), 0) * Real(4 * std::numbers::pi)); });
    const auto energy = [&] {
        double sum = 0;
        for (const Vec3& u : w.column<field::velocity>()) sum += u.cast<double>().squaredNorm();
        return sum;
    };
    const double L = w.angular_momentum().z(), E = energy();
    const Mat3 turn = Eigen::AngleAxis<Real>(Real(4 * std::numbers::pi / 100), Vec3::UnitZ()).toRotationMatrix();
    for (int s = 0; s < 100; ++s) {
        w.step(0.01);
        for (Vec3& x : w.column<field::position>()) x = turn * x;
        for (Vec3& u : w.column<field::velocity>()) u = turn * u;
    }
    CHECK(w.angular_momentum().z() == Approx(L).epsilon(0.001));
    CHECK(energy() == Approx(E).epsilon(0.01));
}

}  // namespace viscosity_test

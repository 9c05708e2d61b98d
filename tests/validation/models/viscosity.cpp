/// Viscous models against exact solutions. Runs have no pressure: the flows are parallel, or decay before particles have moved far.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "engine/models/boundary/wall.h"
#include "engine/models/pressure/poisson.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "tests/support/runs.h"
#include "tests/support/scene_text.h"
#include "tests/support/viscous_forms.h"

using namespace whorl;
using namespace whorl::test;

namespace viscosity_test {

namespace {

using Form = ViscousForm;

/// Longest step of an explicit form [s].
double longest_step(Form form, int dimensions, double d, double nu) {
    return viscous_step(support_of(form) * d, (form == Form::monaghan ? monaghan_stiffness(dimensions) : 1) * nu);
}

/// Calls test(form, dimensions, depth of the box along z [m]) for all forms, in 3D and 2D.
template <class F>
void in_space_and_plane(double depth, const F& test) {
    for (Form form : viscous_forms)
        for (int dimensions : {3, 2}) {
            INFO(name_of(form) << " in " << dimensions << " dimensions");
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

TEST_CASE("a Taylor-Green vortex decays as exp(-2 nu k^2 t) within 2 % of its rate, 32 particles per wave", "[validation][viscosity]") {
    const double L = 1, d = L / 32, k = 2 * std::numbers::pi / L, nu = 1;
    in_space_and_plane(8 * d, [&](Form form, int dimensions, double depth) {
        const double support = support_of(form);
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(L), Real(L), Real(depth)), {true, true, dimensions == 3}});
        w.use(viscous_step_of(form, 1));
        w.world.step.gravity.setZero();
        w.place(Vec3::Zero(), Vec3(Real(L), Real(L), Real(depth)), 1000 * nu, [&](const Vec3& x) {
            return Vec3(Real(std::sin(k * x.x()) * std::cos(k * x.y())), Real(-std::cos(k * x.x()) * std::sin(k * x.y())), 0);
        });
        // To 1/e. The implicit step is first order in time, so it is compared with its factor 1/(1 + 2 nu k^2 dt) per step.
        const double end = 1 / (2 * nu * k * k);
        const int steps = is_implicit(form) ? 20 : static_cast<int>(std::ceil(end / longest_step(form, dimensions, d, nu)));
        const double dt = end / steps;
        const double start = vortex_amplitude(w, k);
        for (int s = 0; s < steps; ++s) w.step(dt);
        const double rate = -std::log(vortex_amplitude(w, k) / start);
        const double exact = is_implicit(form) ? steps * std::log(1 + 2 * nu * k * k * dt) : -steps * std::log(1 - 2 * nu * k * k * dt);
        CHECK(rate == Approx(exact).epsilon(0.02));
    });
}

TEST_CASE("Couette and Poiseuille flow, added, start as their series within 2 % of the largest speed",
          "[validation][viscosity][boundary]") {
    // Between y = 0 and 1, nu = 1, 24 particles across, from rest, under the acceleration 8 and with the upper wall at the speed 1.
    const double pi = std::numbers::pi, d = 1.0 / 24;
    const auto exact = [&](double y, double t) {
        double u = y + 4 * y * (1 - y);
        for (int n = 1; n < 40; ++n) {
            const double couette = 2 / (n * pi) * (n % 2 == 0 ? 1 : -1), poiseuille = n % 2 == 0 ? 0 : -32 / std::pow(n * pi, 3);
            u += (couette + poiseuille) * std::exp(-n * n * pi * pi * t) * std::sin(n * pi * y);
        }
        return u;
    };
    for (Form form : viscous_forms) {
        INFO(name_of(form));
        const double support = support_of(form), width = 2 * std::ceil(support) * d;
        const Real factor = continued_lattice_factor(KernelKind::cubic, Real(support * d), Real(d));
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(width), 1, Real(width)), {true, false, true}});
        w.use(viscous_step_of(form, factor));
        w.world.step.gravity = Vec3(8, 0, 0);
        w.add_wall(1, +1, 0);
        w.add_wall(1, -1, 1);
        w.move_wall(1, Vec3(1, 0, 0));
        w.place(Vec3::Zero(), Vec3(Real(width), 1, Real(width)), 1000);
        double worst = 0, time = 0;
        for (const double until : {0.05, 0.1, 0.2}) {
            const double most = is_implicit(form) ? 1e-3 : 0.9 * longest_step(form, 3, d, 1);
            const int steps = static_cast<int>(std::ceil((until - time) / most));
            for (int s = 0; s < steps; ++s) w.step((until - time) / steps);
            time = until;
            const auto x = w.column<field::position>(), u = w.column<field::velocity>();
            for (std::size_t i = 0; i < x.size(); ++i) worst = std::max(worst, std::abs(u[i].x() - exact(x[i].y(), time)));
        }
        CHECK(worst < 0.02 * 1.5625);
    }
}

namespace {

/// The published operator. @param assembled as a matrix, or matrix-free
Stage published_viscosity(bool assembled, const ViscosityOptions& options) {
    return assembled ? make_stage("viscosity", "viscosity", AssembledViscosity(options))
                     : make_stage("viscosity", "viscosity", UncorrectedViscosity(options));
}

/// S/k for u = sin(ky) on a lattice: its uncorrected gradient is S cos(ky), S = sum_j V |W'|/r y sin(ky).
double gradient_symbol(double k, double d, double support) {
    const CubicKernel W(static_cast<Real>(support * d));
    const int reach = static_cast<int>(support) + 1;
    double S = 0;
    for (int a = -reach; a <= reach; ++a)
        for (int b = -reach; b <= reach; ++b)
            for (int c = -reach; c <= reach; ++c)
                if (a != 0 || b != 0 || c != 0)
                    S -=
                        static_cast<double>(W.slope(static_cast<Real>(d * std::sqrt(a * a + b * b + c * c)))) * b * d * std::sin(k * b * d);
    return S * d * d * d / k;
}

}  // namespace

TEST_CASE("the published full viscosity damps a shear wave by nu times its lattice sum squared, to 1e-4", "[validation][viscosity]") {
    // The force is the transpose of the gradient: the rate is nu S^2 with the S of gradient_symbol(). For long waves S/k is the factor that
    // gradients of linear fields have on a lattice, 1.020 with R = 2 d: they decay 4 % too fast, however many particles a wave has. Shorter
    // waves lose some of that to the kernel's width: 2.7 % too fast with 32 particles a wave, 3.7 % with 64. With R = 4 d the factor is 1.
    const double two_pi = 2 * std::numbers::pi;
    const auto long_waves = [&](double support) { return std::pow(gradient_symbol(two_pi, 1e-3, support), 2); };
    CHECK(long_waves(2) == Approx(1.0405).epsilon(1e-3));
    CHECK(long_waves(4) == Approx(1).epsilon(1e-3));
    struct Case {
        bool assembled;
        int particles;
        double support, over_exact;
    };
    for (const Case& one : {Case{true, 32, 2, 1.0272}, Case{true, 64, 2, 1.0371}, Case{false, 32, 2, 1.0272}, Case{false, 64, 2, 1.0371},
                            Case{false, 32, 4, 0.9543}}) {
        INFO((one.assembled ? "assembled" : "matrix-free") << ", " << one.particles << " a wave, R/d = " << one.support);
        const double d = 1.0 / one.particles, k = two_pi, nu = 1, dt = 1 / (nu * k * k);
        const Real width = static_cast<Real>(2 * one.support * d);
        TestWorld w(d, one.support, Domain{Vec3::Zero(), Vec3(width, 1, width), {true, true, true}});
        ViscosityOptions options;
        options.limits.tolerance = 1e-6, options.penalty = 0;
        w.use({make_stage("density", "density", Density{}), published_viscosity(one.assembled, options)});
        w.place(Vec3::Zero(), Vec3(width, 1, width), 1000 * nu, [&](const Vec3& x) { return Vec3(Real(std::sin(k * x.y())), 0, 0); });
        w.step(dt);
        double amplitude = 0;
        for (Index i = 0; i < w.world.fluid.size(); ++i)
            amplitude += 2 * w.column<field::velocity>()[i].x() * std::sin(k * w.column<field::position>()[i].y()) / w.world.fluid.size();
        const double over_exact = std::pow(gradient_symbol(k, d, one.support), 2);
        // m/rho twice in the gradients, 1/rho in the acceleration; the density on a lattice is not quite that at rest.
        const double rate = over_exact * nu * k * k / std::pow(w.column<field::density>()[0] / 1000, 3);
        CHECK(amplitude == Approx(1 / (1 + rate * dt)).epsilon(1e-4));
        CHECK(over_exact == Approx(one.over_exact).epsilon(1e-3));
    }
}

TEST_CASE("a force sin(ky) drives a flow to f/(nu k^2) (1 - exp(-nu k^2 t)) sin(ky) within 1 %", "[validation][viscosity]") {
    // Kolmogorov's flow, so slow that no particle passes its neighbour.
    const text::Point low{0, 0, 0}, high{0.25, 1, 0.25};
    Simulation simulation =
        simulation_of(text::time(0.06, "max_step = 1e-3") + text::domain(low, high, "periodic = [true, true, true]\ngravity = [0, 0, 0]") +
                      text::fluid(0.03125, 1000, "force = [\"0.5*sin(2*pi*y)\", \"0\", \"0\"]") + text::models("none", "explicit") +
                      text::block(low, high));
    run_until(simulation, 0.06);
    const double k = 2 * std::numbers::pi, exact = 0.5 / (k * k) * (1 - std::exp(-k * k * 0.06));
    const double amplitude = mean_of(simulation, [&](const Vec3d& x, const Vec3d& u) { return 2 * u.x() * std::sin(k * x.y()); });
    CHECK(amplitude == Approx(exact).epsilon(0.01));
}

TEST_CASE("a film on an incline keeps its half parabola within 2 % with forms without surface shear", "[validation][viscosity][boundary]") {
    // u = g (2 H y - y^2)/(2 nu), from the exact flow, for nu t/H^2 = 1: the error has reached 1 - exp(-pi^2/4) = 92 % of the steady error.
    const double H = 1, d = H / 16, nu = 1, g = 2;  // largest speed g H^2/(2 nu) = 1
    in_space_and_plane(8 * d, [&](Form form, int dimensions, double depth) {
        if (form == Form::monaghan && dimensions == 3) return;  // the most expensive form; in 3D the series above tests it
        const double support = support_of(form), width = 8 * d;
        const Real factor = continued_lattice_factor({KernelKind::cubic, dimensions}, Real(support * d), Real(d));
        TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(Real(width), Real(2 * H), Real(depth)), {true, false, dimensions == 3}});
        w.use(viscous_step_of(form, factor));
        w.world.step.gravity = Vec3(Real(g), 0, 0);
        w.add_wall(1, +1, 0);
        w.place(Vec3::Zero(), Vec3(Real(width), Real(H), Real(depth)), 1000 * nu,
                [&](const Vec3& x) { return Vec3(Real(g / (2 * nu) * x.y() * (2 * H - x.y())), 0, 0); });
        const double dt = is_implicit(form) ? 0.02 : 0.9 * longest_step(form, dimensions, d, nu);
        for (int s = 0; s < static_cast<int>(1 / dt); ++s) w.step(dt);
        const auto x = w.column<field::position>();
        const auto u = w.column<field::velocity>();
        double worst = 0;
        for (std::size_t i = 0; i < x.size(); ++i)
            worst = std::max<double>(worst, std::abs(u[i].x() - g / (2 * nu) * x[i].y() * (2 * H - x[i].y())));
        CHECK(worst < 0.02);
    });
}

namespace {

struct PublishedFlow {
    bool assembled;
    int dimensions, layers;
    double support, moved;  ///< kernel radius over d; displacement of particles from their lattice, over d
    Real penalty = viscous_penalty;
};

/// Couette flow (0), a film on an incline from rest (1) or a block that slides on a plate (2), H = nu = 1, largest speed about 1, at
/// t = 0.2: root of the mean square of the difference from the series, over the largest speed.
double published_error(const PublishedFlow& one, int flow) {
    const double pi = std::numbers::pi, d = 1.0 / one.layers, width = 2 * one.support * d, depth = one.dimensions == 3 ? width : 0, t = 0.2;
    const Real factor = continued_lattice_factor({KernelKind::cubic, one.dimensions}, Real(one.support * d), Real(d));
    TestWorld w(d, one.support, Domain{Vec3::Zero(), Vec3(Real(width), 2, Real(depth)), {true, false, one.dimensions == 3}});
    ViscosityOptions options;
    options.solid_factor = factor, options.penalty = one.penalty;
    w.use({make_stage("density", "density", Density{factor}), make_stage("gravity", "move", Gravity{}), make_stage("kick", "move", Kick{}),
           published_viscosity(one.assembled, options)});
    w.world.step.gravity = Vec3(Real(flow == 1 ? 2 : 0), 0, 0);
    w.add_wall(1, +1, 0);
    if (flow == 0) w.add_wall(1, -1, 1), w.world.solids.all[1].pose.velocity = Vec3(1, 0, 0);
    w.place(Vec3::Zero(), Vec3(Real(width), 1, Real(depth)), 1000, [&](const Vec3&) { return Vec3(Real(flow == 2), 0, 0); });
    auto x = w.column<field::position>(), u = w.column<field::velocity>();
    for (std::size_t i = 0; i < x.size(); ++i)
        for (int a = 0; a < one.dimensions; ++a) x[i][a] += Real(one.moved * d * std::sin(10.0 * static_cast<double>(i) + a));
    for (int s = 0; s < 25; ++s) w.step(t / 25);
    const auto exact = [&](double y) {
        double sum = flow == 0 ? y : flow == 1 ? 2 * y - y * y : 0;
        for (int n = 1; n < 30; ++n) {
            const double k = (flow == 0 ? n : n - 0.5) * pi, part = std::exp(-k * k * t) * std::sin(k * y);
            sum += flow == 0 ? (n % 2 == 0 ? 2 : -2) / k * part : flow == 1 ? -4 / (k * k * k) * part : 2 / k * part;
        }
        return sum;
    };
    double error = 0;
    for (std::size_t i = 0; i < x.size(); ++i) error += std::pow(u[i].x() - exact(x[i].y()), 2);
    return std::sqrt(error / static_cast<double>(x.size())) / exact(1);
}

}  // namespace

TEST_CASE("the published viscosity sticks to walls within 6 % (Couette, film, block), as printed it does not",
          "[validation][viscosity][boundary]") {
    // On lattices within 2 %. Off lattices the printed gradient itself has errors of a few per cent.
    const PublishedFlow all[] = {{false, 3, 10, 2, 0}, {true, 3, 9, 2, 0.1},   {false, 3, 10, 3, 0.1},  {false, 2, 20, 2, 0},
                                 {true, 2, 12, 2, 0},  {false, 2, 11, 2, 0.1}, {false, 2, 12, 2, 0, 0}, {true, 2, 11, 2, 0, 0}};
    for (const PublishedFlow& one : all)
        for (const int flow : {0, 1, 2}) {
            INFO((one.assembled ? "assembled, " : "matrix-free, ") << one.dimensions << " dimensions, " << one.layers << " layers, R/d = "
                                                                   << one.support << ", moved by " << one.moved << " d, flow " << flow);
            const double error = published_error(one, flow);
            if (one.penalty > 0) CHECK(error < (one.moved > 0 ? 0.06 : 0.02));
            else CHECK(error > 0.2);
        }
}

TEST_CASE("a rotating free body keeps angular momentum within 0.1 %, energy within 1 %, at nu dt/d^2 = 10", "[validation][viscosity]") {
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

TEST_CASE("full: a block of honey sinks on a frictionless plate within 15 % of the exact path, its top within 6 % of the speed",
          "[validation][viscosity]") {
    // A layer at Z of the height H is at ln((1 + a H)/(1 + a (H - Z)))/a, a = rho g t/(3 mu). The densities of a lattice settle by part of
    // a spacing: 12 % of the path at this spacing, 6 % at half of it. With the pressures of sides and start neglected it is 38 %, the speed
    // 11 %.
    const double d = 0.01, H = 0.1, end = 0.3;
    Simulation s = simulation_of(text::time(end, "max_step = 5e-3") + text::domain({-0.1, -0.02, -0.1}, {0.1, 0.12, 0.1}) +
                                 text::fluid(d, 1000) + text::models("ppe", "full") + text::block({-H / 2, 0, -H / 2}, {H / 2, H, H / 2}) +
                                 text::plane({0, 0, 0}, {0, 1, 0}, "slip = \"free\""));
    const auto top = [&] {  // mean of the hundred highest
        std::vector<double> y;
        for (const Vec3& x : positions(s)) y.push_back(static_cast<double>(x.y()));
        std::sort(y.rbegin(), y.rend());
        return std::accumulate(y.begin(), y.begin() + 100, 0.0) / 100;
    };
    const double Z = top();
    const auto exact = [&](double t) {
        const double a = 9810 * t / 3000;
        return Z - std::log((1 + a * H) / (1 + a * (H - Z))) / a;
    };
    run_until(s, end - 0.05);
    const double before = top();
    run_until(s, end);
    CHECK(Z - top() == Approx(exact(end)).epsilon(0.15));
    CHECK(before - top() == Approx(exact(end) - exact(end - 0.05)).epsilon(0.06));
}

}  // namespace viscosity_test

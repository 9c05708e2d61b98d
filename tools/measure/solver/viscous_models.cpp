/// Properties of each viscous model: conservation, stiffness of a rope of few particles, decay of waves, and cost of a step.
#include <CLI/CLI.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "engine/geometry/shape.h"
#include "engine/models/motion/motion.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/particles/sample.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"
#include "tools/measure/solver/subcommands.h"

namespace whorl {
namespace {

using test::TestWorld;

/// A viscous model as a linear map from velocities to viscous accelerations.
struct ViscousModel {
    std::string name;
    bool implicit = false;
    double support = 2;  ///< recommended kernel radius over spacing
    /// Viscous acceleration [m/s^2] at the world's velocities. Needs its pairs, density and viscosity.
    std::function<std::vector<Vec3>(TestWorld&)> acceleration;
    /// Stages of a time step with this model; empty if its cost is not measured.
    std::function<std::vector<Stage>(double tolerance)> stages;
};

template <class F>
Read<F> read(TestWorld& w) {
    return {std::as_const(w.world.fluid).template column<F>()};
}

/// Viscous acceleration -(A u - u)/dt of an implicit operator A, set up with dt = 1 s.
template <class Operator, class SetUp>
std::vector<Vec3> acceleration_of(TestWorld& w, const SetUp& set_up) {
    const auto u = w.column<field::velocity>();
    w.world.step.dt = Real(1);
    Operator A;
    set_up(A, w.world);
    std::vector<Vec3> y(u.size());
    A.force(u, y);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = u[i] - y[i];
    return y;
}

std::vector<Vec3> explicit_acceleration(TestWorld& w, bool monaghan) {
    std::vector<Vec3> a(w.column<field::velocity>().size(), Vec3::Zero());
    World& c = w.world;
    ExplicitViscosity{{.laplacian = monaghan ? LaplacianForm::monaghan : LaplacianForm::brookshaw}}(
        c.context(), read<field::role>(w), read<field::density>(w), read<field::viscosity>(w), read<field::velocity>(w), {{Span<Vec3>(a)}});
    return a;
}

/// Acceleration by XSPH. alpha is chosen so that the viscosity alpha 0.075 R^2/(2 dt) is nu.
std::vector<Vec3> xsph_acceleration(TestWorld& w) {
    const StepContext& step = w.world.step;
    const Real nu = w.column<field::viscosity>()[0] / step.rest_density;
    std::vector<Vec3> change(w.column<field::velocity>().size()), u(w.column<field::velocity>().begin(), w.column<field::velocity>().end());
    XsphViscosity{1}(w.world.context(), read<field::role>(w), read<field::density>(w), {Span<Vec3>(change)}, {{Span<Vec3>(u)}});
    for (Vec3& a : change) a *= nu / (Real(0.0375) * step.support * step.support);
    return change;
}

std::vector<Stage> around(Stage viscosity, bool acceleration) {
    std::vector<Stage> all{make_stage("density", "density", Density{}), make_stage("gravity", "move", Gravity{})};
    if (acceleration) all.push_back(std::move(viscosity));
    all.push_back(make_stage("kick", "move", Kick{}));
    if (!acceleration) all.push_back(std::move(viscosity));
    return all;
}

/// xsph, explicit (with either Laplacian), full_assembled, full.
std::vector<ViscousModel> viscous_models() {
    const auto stage = [](auto s) { return make_stage("viscosity", "viscosity", std::move(s)); };
    std::vector<ViscousModel> all;
    all.push_back({"xsph", false, 2, xsph_acceleration, {}});
    for (const bool monaghan : {false, true})
        all.push_back({monaghan ? "explicit monaghan" : "explicit brookshaw", false, monaghan ? 4.0 : 2.0,
                       [monaghan](TestWorld& w) { return explicit_acceleration(w, monaghan); },
                       [=](double) {
                           return around(
                               stage(ExplicitViscosity{{.laplacian = monaghan ? LaplacianForm::monaghan : LaplacianForm::brookshaw}}),
                               true);
                       }});
    all.push_back({"full_assembled", true, 2,
                   [](TestWorld& w) {
                       return acceleration_of<AssembledOperator>(w, [&](AssembledOperator& A, World& c) {
                           A.set_up({.penalty = 0}, c.context(), read<field::role>(w), read<field::density>(w), read<field::viscosity>(w));
                       });
                   },
                   [=](double tolerance) {
                       ViscosityOptions o;
                       o.limits = {tolerance, 5000}, o.penalty = 0;
                       return around(stage(AssembledViscosity(o)), false);
                   }});
    all.push_back({"full", true, 2,
                   [](TestWorld& w) {
                       return acceleration_of<ViscousOperator>(w, [&](ViscousOperator& A, World& c) {
                           A.set_up({}, c.context(), read<field::role>(w), read<field::viscosity>(w));
                       });
                   },
                   [=](double tolerance) {
                       ViscosityOptions o;
                       o.limits = {tolerance, 5000};
                       return around(stage(FullViscosity(o)), false);
                   }});
    return all;
}

/// A free body of particles at x with viscosity mu [Pa s]; computes its neighbours and density.
TestWorld body(const std::vector<Vec3>& x, double spacing, double support, double mu, const std::vector<Stage>& stages = {}) {
    Vec3 low = Vec3::Constant(std::numeric_limits<Real>::max()), high = -low;
    for (const Vec3& one : x) low = low.cwiseMin(one), high = high.cwiseMax(one);
    const Vec3 room = Vec3::Constant(static_cast<Real>(4 * support * spacing));
    TestWorld w(spacing, support, Domain{low - room, high + room, {}});
    w.use(stages);
    w.world.fluid.declare(field_info<field::density>(), true);
    w.world.fluid.resize(static_cast<Index>(x.size()));
    std::copy(x.begin(), x.end(), w.column<field::position>().begin());
    for (Real& one : w.column<field::viscosity>()) one = static_cast<Real>(mu);
    w.world.step.gravity.setZero();
    w.find_pairs();
    Density{}(w.world.context(), {w.column<field::density>()});
    return w;
}

/// Particles of a cylinder along x with its middle at the origin, as blue noise [m].
std::vector<Vec3> rope(double radius, double length, double spacing) {
    ShapeKeys keys;
    keys.kind = "cylinder";
    keys.from = Vec3d(-length / 2, 0, 0);
    keys.to = Vec3d(length / 2, 0, 0);
    keys.radius = radius;
    Domain domain;
    domain.max = Vec3::Constant(static_cast<Real>(length));
    domain.min = -domain.max;
    return sample_shape(*make_shape(keys), Sampling::blue_noise, static_cast<Real>(spacing), domain, 1);
}

constexpr double d = 0.01, density = 1000;

double dissipation(TestWorld& w, const std::vector<Vec3>& acceleration) {
    const auto u = w.column<field::velocity>();
    double sum = 0;
    for (std::size_t i = 0; i < u.size(); ++i) sum -= w.world.step.mass * u[i].cast<double>().dot(acceleration[i].cast<double>());
    return sum;
}

/// Errors of one evaluation of the model at random velocities: total force over the sum of |m a|, and total torque over that sum times half
/// the body's length. Both are zero if the model conserves momentum and angular momentum.
void kept(const ViscousModel& model, double& momentum, double& angular) {
    std::vector<Vec3> x = rope(3.5 * d, 20 * d, d);
    TestWorld w = body(x, d, model.support, density);
    RandomNumbers random(5);
    for (Vec3& u : w.column<field::velocity>()) u = Vec3(Real(random()), Real(random()), Real(random()));
    const std::vector<Vec3> a = model.acceleration(w);
    Vec3d p = Vec3d::Zero(), L = Vec3d::Zero();
    double scale = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        p += a[i].cast<double>();
        L += x[i].cast<double>().cross(a[i].cast<double>());
        scale += a[i].norm();
    }
    momentum = p.norm() / scale;
    angular = L.norm() / (scale * 10 * d);
}

/// Fraction of a rigid rotation about a rope's axis that an implicit step with nu dt/d^2 = 10 destroys, from the rate of dissipation.
double braking(const ViscousModel& model) {
    std::vector<Vec3> x = rope(2.5 * d, 20 * d, d);
    const double nu = 1, dt = 10 * d * d / nu;
    TestWorld w = body(x, d, model.support, density * nu);
    double energy = 0;
    const auto u = w.column<field::velocity>();
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = Vec3(1, 0, 0).cross(x[i]), energy += 0.5 * w.world.step.mass * u[i].squaredNorm();
    const double rate = dissipation(w, model.acceleration(w)) / (2 * energy);  // relative decay rate of the rotation [1/s]
    return 1 - 1 / (1 + rate * dt);
}

enum class Strain { stretching, bending, torsion };

/// Dissipation of a rope `across` particles thick in pure stretching, bending or torsion, over that of the continuum. The latter is 3 mu A,
/// 3 mu I or 2 mu I times the squared rate (1 here) and the length.
double stiffness(const ViscousModel& model, Strain strain, int across) {
    const double a = 0.5 * across * d, L = 40 * d, mu = density;
    std::vector<Vec3> x = rope(a, L, d);
    TestWorld w = body(x, d, model.support, mu);
    const auto u = w.column<field::velocity>();
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Real X = x[i].x(), Y = x[i].y(), Z = x[i].z();
        if (strain == Strain::stretching) u[i] = Vec3(X, -Y / 2, -Z / 2);
        if (strain == Strain::bending) u[i] = Vec3(-X * Y, X * X / 2 + (Y * Y - Z * Z) / 4, Y * Z / 2);
        if (strain == Strain::torsion) u[i] = Vec3(0, -X * Z, X * Y);
    }
    const double A = std::numbers::pi * a * a, I = A * a * a / 4;
    const double exact = strain == Strain::stretching ? 3 * mu * A * L : strain == Strain::bending ? 3 * mu * I * L : 2 * mu * I * L;
    return dissipation(w, model.acceleration(w)) / exact;
}

/// A periodic lattice with `side` particles along y and two kernel radii along x and z, with the velocity (sin ky, 0, 0).
TestWorld wave(const ViscousModel& model, int side, double nu) {
    const double L = side * d, width = 2 * model.support * d, k = 2 * std::numbers::pi / L;
    TestWorld w(d, model.support, Domain{Vec3::Zero(), Vec3(Real(width), Real(L), Real(width)), {true, true, true}});
    w.world.fluid.declare(field_info<field::density>(), true);
    w.place(Vec3::Zero(), Vec3(Real(width), Real(L), Real(width)), density * nu,
            [&](const Vec3& x) { return Vec3(Real(std::sin(k * x.y())), 0, 0); });
    w.find_pairs();
    for (Real& rho : w.column<field::density>()) rho = Real(density);
    return w;
}

/// Decay rate of a shear wave over nu k^2. @param particles per wavelength
double shear_wave(const ViscousModel& model, int particles) {
    TestWorld w = wave(model, particles, 1);
    double energy = 0;
    for (const Vec3& u : w.column<field::velocity>()) energy += w.world.step.mass * u.squaredNorm();
    const double k = 2 * std::numbers::pi / (particles * d);
    return dissipation(w, model.acceleration(w)) / (energy * k * k);
}

/// Largest stable nu dt/d^2 of an explicit step on a lattice: 2 over the largest eigenvalue, which power iteration finds.
double largest_step(const ViscousModel& model) {
    TestWorld w = wave(model, 12, 1);
    const auto u = w.column<field::velocity>();
    RandomNumbers random(3);
    for (Vec3& one : u) one = Vec3(Real(random()), Real(random()), Real(random())) - Vec3::Constant(Real(0.5));
    double eigenvalue = 0;
    for (int k = 0; k < 200; ++k) {
        const std::vector<Vec3> a = model.acceleration(w);
        double before = 0, after = 0;
        for (std::size_t i = 0; i < a.size(); ++i) before += u[i].squaredNorm(), after += a[i].squaredNorm();
        eigenvalue = std::sqrt(after / before);
        for (std::size_t i = 0; i < a.size(); ++i) u[i] = a[i] / Real(std::sqrt(after));
    }
    return 2 / (eigenvalue * d * d);
}

/// Iterations and CPU ns per particle of the first step of 4,000 particles, without the neighbour search. @param K nu dt/d^2
void step(const ViscousModel& m, double K, int& iterations, double& nanoseconds) {
    TestWorld w = body(rope(7 * d, 26 * d, d), d, m.support, density, m.stages(1e-3));
    for (std::size_t i = 0; i < w.column<field::velocity>().size(); ++i) {
        const Vec3 x = w.column<field::position>()[i] / Real(10 * d);
        w.column<field::velocity>()[i] = Vec3(std::sin(x.y()), x.x() * x.x(), std::cos(2 * x.x()));
    }
    const double start = cpu_seconds();
    w.step(K * d * d);
    const double stepped = cpu_seconds();
    w.find_pairs();
    const double search = cpu_seconds() - stepped;
    nanoseconds = 1e9 * (stepped - start - search) / static_cast<double>(w.world.fluid.size());
    iterations = m.implicit ? w.world.report.solves.at(0).report.iterations : 0;
}

void print_properties(const ViscousModel& m) {
    const auto print = [&](const std::string& quantity, double value) { print_csv(m.name, m.support, quantity, value); };
    double momentum = 0, angular = 0;
    kept(m, momentum, angular);
    print("momentum", momentum);
    print("angular_momentum", angular);
    print("braking", braking(m));
    for (const int across : {3, 4, 5, 6, 8}) {
        print(fmt::format("stretching_{}", across), stiffness(m, Strain::stretching, across));
        print(fmt::format("bending_{}", across), stiffness(m, Strain::bending, across));
        print(fmt::format("torsion_{}", across), stiffness(m, Strain::torsion, across));
    }
    for (const int particles : {8, 16, 32, 64}) print(fmt::format("decay_{}", particles), shear_wave(m, particles));
    if (!m.implicit) print("largest_step", largest_step(m));
    if (!m.stages) return;
    for (const double K : m.implicit ? std::vector<double>{1, 100, 1e4} : std::vector<double>{0.1}) {
        int iterations = 0;
        double nanoseconds = 0;
        step(m, K, iterations, nanoseconds);
        print(fmt::format("iterations_{:g}", K), iterations);
        print(fmt::format("nanoseconds_{:g}", K), nanoseconds);
    }
}

}  // namespace

void add_viscous_models(CLI::App& program) {
    program.add_subcommand("viscous_models", "conservation, stiffness of ropes, decay of waves and cost of a step by viscous model")
        ->callback([] {
            print_csv("model", "support", "quantity", "value");
            for (const ViscousModel& model : viscous_models()) print_properties(model);
        });
}

}  // namespace whorl

/// Per viscous model: conservation, stiffness of a rope of few particles, decay of waves, and cost of a step.
#include <CLI/CLI.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "tools/measure/solver/subcommands.h"
#include "tools/measure/solver/viscous_models.h"

namespace whorl {
namespace {

using test::TestWorld;

constexpr double d = 0.01, density = 1000;

double dissipation(TestWorld& w, const std::vector<Vec3>& acceleration) {
    const auto u = w.column<field::velocity>();
    double sum = 0;
    for (std::size_t i = 0; i < u.size(); ++i) sum -= w.world.step.mass * u[i].cast<double>().dot(acceleration[i].cast<double>());
    return sum;
}

/// Momentum and angular momentum that one evaluation makes from nothing, over the sum of |m a| (and the body's half length), for a noisy
/// velocity.
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

/// The fraction of a rigid rotation about a rope's axis that a step at nu dt/d^2 = 10 destroys, extrapolated to one second.
double braking(const ViscousModel& model) {
    std::vector<Vec3> x = rope(2.5 * d, 20 * d, d);
    const double nu = 1, dt = 10 * d * d / nu;
    TestWorld w = body(x, d, model.support, density * nu);
    double energy = 0;
    const auto u = w.column<field::velocity>();
    for (std::size_t i = 0; i < x.size(); ++i) u[i] = Vec3(1, 0, 0).cross(x[i]), energy += 0.5 * w.world.step.mass * u[i].squaredNorm();
    const double rate = dissipation(w, model.acceleration(w)) / (2 * energy);  // of the rotation's speed
    return 1 - 1 / (1 + rate * dt);
}

enum class Strain { stretching, bending, torsion };

/// Dissipation of a rope `across` particles thick in a field of pure stretching, bending or torsion, over that of the continuum: 3 mu A, 3
/// mu I, 2 mu I times the rate squared and the length.
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

/// A periodic lattice with `side` particles along y and a few along x and z, with the velocity (sin ky, 0, 0).
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

/// Decay rate of a shear wave of that many particles over nu k^2.
double shear_wave(const ViscousModel& model, int particles) {
    TestWorld w = wave(model, particles, 1);
    double energy = 0;
    for (const Vec3& u : w.column<field::velocity>()) energy += w.world.step.mass * u.squaredNorm();
    const double k = 2 * std::numbers::pi / (particles * d);
    return dissipation(w, model.acceleration(w)) / (energy * k * k);
}

/// nu dt/d^2 at which the fastest mode on a lattice is thrown over: 2 over the largest eigenvalue, by power iteration.
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

/// Iterations and CPU ns a particle of a step of 4,000 particles from rest, without the neighbour search; K = nu dt/d^2.
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
    program.add_subcommand("viscous_models", "what each viscous model keeps, stiffness of ropes, decay of waves, cost of a step")
        ->callback([] {
            print_csv("model", "support", "quantity", "value");
            for (const ViscousModel& model : viscous_models()) print_properties(model);
        });
}

}  // namespace whorl

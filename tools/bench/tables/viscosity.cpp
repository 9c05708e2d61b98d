/// Prints docs/viscosity.md: what each viscous model keeps, how stiff a rope of few particles is with it, how fast waves decay, what a step
/// costs, and the iterations of the preconditioners. whorl_viscosity_table > docs/viscosity.md; with --large also half a million particles
/// (an hour, 4 GB).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "tools/bench/tables/viscous_models.h"
#include "tools/bench/tables/viscous_preconditioners.h"

using namespace whorl;
using test::TestWorld;

namespace {

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

/// The part of a rigid rotation about a rope's axis that one second's worth of a step at nu dt/d^2 = 10 destroys, were it to go on as it
/// begins.
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

void print_models() {
    fmt::print(
        "## What each model keeps, and how stiff it is\n\n"
        "Free bodies of blue noise. Momentum and angular momentum: what one evaluation makes from nothing, over the sum of the forces' "
        "sizes (times the body's "
        "half length). Braking: the part of a rigid rotation about a rope's axis, 5 particles across, that a step with nu dt/d^2 = 10 "
        "takes away.\n\n"
        "| model | R/d | momentum | angular momentum | braking |\n|---|---|---|---|---|\n");
    for (const ViscousModel& m : viscous_models()) {
        double p = 0, L = 0;
        kept(m, p, L);
        fmt::print("| {} | {:g} | {:.1e} | {:.1e} | {:.1f} % |\n", m.name, m.support, p, L, 100 * braking(m));
    }
    fmt::print(
        "\nDissipation of a rope, 3 to 8 particles across and 40 long, in pure stretching, bending and torsion, over the exact 3 mu A, 3 "
        "mu I and 2 mu I; 1 is right. "
        "One application, no time stepping.\n\n| model | R/d |");
    const std::vector<std::pair<Strain, const char*>> strains{
        {Strain::stretching, "stretching"}, {Strain::bending, "bending"}, {Strain::torsion, "torsion"}};
    for (const auto& [strain, name] : strains) fmt::print(" {} 3 | 4 | 5 | 6 | 8 |", name);
    fmt::print("\n|---|---|");
    for (int k = 0; k < 15; ++k) fmt::print("---|");
    for (const ViscousModel& m : viscous_models()) {
        fmt::print("\n| {} | {:g} |", m.name, m.support);
        for (const auto& [strain, name] : strains)
            for (const int across : {3, 4, 5, 6, 8}) fmt::print(" {:.2f} |", stiffness(m, strain, across));
    }
    fmt::print(
        "\n\n## Waves and steps\n\n"
        "Decay of a shear wave along the axis of a lattice, 8 to 64 particles long, over nu k^2; the order in the spacing of what changes "
        "from 16 to 64 particles "
        "(the monaghan form converges to its lattice's stiffness, not to 1). Largest stable explicit step nu dt/d^2 on a lattice (none for "
        "implicit models). "
        "CPU of a step of 4,000 particles on one thread at nu dt/d^2 = 0.1 (explicit) and 100 (implicit, from rest, tolerance 1e-3), "
        "without the neighbour search.\n\n"
        "| model | R/d | 8 | 16 | 32 | 64 | order | largest nu dt/d^2 | iterations at 1 | at 100 | at 10^4 | ns a particle |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const ViscousModel& m : viscous_models()) {
        fmt::print("| {} | {:g} |", m.name, m.support);
        double rate[4];
        for (int k = 0; k < 4; ++k) fmt::print(" {:.3f} |", rate[k] = shear_wave(m, 8 << k));
        fmt::print(" {:.1f} |", std::log2((rate[1] - rate[2]) / (rate[2] - rate[3])));
        fmt::print(" {} |", m.implicit ? "any" : fmt::format("{:.2f}", largest_step(m)));
        if (!m.stages) {
            fmt::print(" | | | |\n");
            continue;
        }
        double ns = 0;
        for (const double K : {1.0, 100.0, 1e4}) {
            if (!m.implicit && K > 1) {
                fmt::print(" | ");
                continue;
            }
            const double dt = (m.implicit ? K : 0.1) * d * d;
            TestWorld w = body(rope(7 * d, 26 * d, d), d, m.support, density, m.stages(1e-3));
            for (std::size_t i = 0; i < w.column<field::velocity>().size(); ++i) {
                const Vec3 x = w.column<field::position>()[i] / Real(10 * d);
                w.column<field::velocity>()[i] = Vec3(std::sin(x.y()), x.x() * x.x(), std::cos(2 * x.x()));
            }
            const double before = cpu_seconds();
            w.step(dt);
            const double search = cpu_seconds();
            w.find_pairs();
            const double spent = (search - before) - (cpu_seconds() - search);
            if (!m.implicit || K == 100) ns = 1e9 * spent / static_cast<double>(w.world.fluid.size());
            fmt::print(" {} |", m.implicit ? std::to_string(w.world.report.solves.at(0).report.iterations) : "");
        }
        fmt::print(" {:.0f} |\n", ns);
    }
}

}  // namespace

int main(int count, char** arguments) {
    CLI::App app{"Viscous models beside each other, in Markdown."};
    PreconditionerRows rows;
    bool only_large = false, only_preconditioners = false;
    std::string solve;
    app.add_flag("--large", rows.large, "also half a million particles (an hour, 4 GB)");
    app.add_flag("--only-large", only_large, "half a million particles alone");
    app.add_flag("--preconditioners", only_preconditioners, "no models, preconditioners alone");
    app.add_option("--solve", solve, "preconditioners of this solve alone")->check(CLI::IsMember({"full", "coupled"}));
    app.add_option("--preconditioner", rows.only, "fills the columns of this one alone")
        ->check(CLI::IsMember({"none", "block_jacobi", "two_level"}));
    app.add_option("--K", rows.K, "nu dt/d^2 of the preconditioners' rows")->capture_default_str();
    CLI11_PARSE(app, count, arguments);
    rows.large = rows.large || only_large, rows.small = !only_large;
    rows.full = solve != "coupled", rows.coupled = solve != "full";
    set_threads(1);
    if (!only_preconditioners) {
        fmt::print(
            "# Viscous models beside each other\n\nGenerated by `build/release/tools/bench/whorl_viscosity_table{}`; the equations are in "
            "physics.md, section 4.\n\n",
            rows.large ? " --large" : "");
        print_models();
    }
    print_preconditioners(rows);
}

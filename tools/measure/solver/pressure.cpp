/// Preconditioners of the pressure solves, measured on the linear systems of a half-filled box under tilted gravity.
#include <CLI/CLI.hpp>
#include <cmath>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/pressure/pressure_multigrid.h"
#include "engine/particles/search.h"
#include "engine/scene/read.h"
#include "engine/simulation/simulation.h"
#include "tools/measure/solver/subcommands.h"

namespace whorl {
namespace {

/// Scene of a cube of 1 m, half full of water, under gravity tilted by 20 degrees. @param layers of particles across the depth of 0.5 m
std::string half_filled_box(int layers, const std::string& form) {
    return fmt::format(R"toml([time]
end = 10
[domain]
min = [-0.1, -0.1, -0.1]
max = [1.1, 1.1, 1.1]
gravity = [3, -9, 1]
[fluid]
spacing = {}
[models]
pressure = "ppe"
[pressure]
form = {}
[[block]]
shape = "box"
min = [0, 0, 0]
max = [1, 0.5, 1]
[[solid]]
shape = "box"
container = true
min = [0, 0, 0]
max = [1, 1, 1]
)toml",
                       0.5 / layers, form == "constraint" ? "\"constraint\"" : "\"projection\"\nsource = \"density\"");
}

/// State of a run after some steps, and the velocities u that the pressure solve of the next step starts from.
struct State {
    Simulation simulation;
    World& w;
    Column<Vec3> u;
    explicit State(const Scene& scene, int steps) : simulation(scene, make_plan(scene)), w(const_cast<World&>(simulation.world())) {
        for (int k = 0; k < steps; ++k) simulation.step(scene.time.end);
        const auto x = std::as_const(w.fluid).column<field::position>();
        NeighbourSearch fluid, solid;
        fluid.find(x, w.step.support, w.step.domain, w.fluid_pairs);
        solid.find(x, w.boundary_particles.position, w.step.support, w.step.domain, w.solid_pairs);
    }
    void predict(double factor, Real dt) {
        w.step.dt = dt * static_cast<Real>(factor);
        const auto now = w.fluid.column<field::velocity>();
        u.assign(now.begin(), now.end());
        for (Vec3& one : u) one += w.step.dt * w.step.gravity;
    }
    Index size() const { return w.fluid.size(); }
};

/// First linear system of a step with the constraint. Its unknowns are the pressures of particles with b > -0.02 rho_0/dt, where b is the
/// source. step_residual is the residual of a density error of 1e-4 rho_0 in the step.
struct ConstraintSystem {
    static constexpr const char* form = "constraint";
    DensityRate D;
    ConstraintMatrix A{D, {}, {}, {}, 0};
    Column<Real> b;
    double step_residual = 0;
    explicit ConstraintSystem(State& s) {
        World& w = s.w;
        Column<Real> rho(s.size());
        b.resize(rho.size());
        const auto role = std::as_const(w.fluid).column<field::role>();
        D.build(WallImage(w.step.kernel, w.step.support, w.step.spacing), w.context(), Read<field::role>{role}, Read<field::velocity>{s.u},
                rho, b);
        A.x = w.fluid_pairs.x_own;
        A.spacing = w.step.spacing;
        A.force.resize(rho.size());
        const Real rho_0 = w.step.rest_density, dt = w.step.dt;
        for (std::size_t i = 0; i < rho.size(); ++i) {
            const Real excess = std::min(rho[i] - rho_0, rho_0 / 20);
            b[i] += (excess > 0 ? Real(0.2) : Real(1)) * excess / dt;
            A.presses.push_back(D.diagonal[i] > 0 && b[i] > Real(-0.02) * rho_0 / dt);
            if (!A.presses[i]) b[i] = 0;
        }
        step_residual = 1e-4 * std::sqrt(static_cast<double>(s.size())) * static_cast<double>(rho_0 / dt);
    }
    PressurePreconditioner none() const { return constraint_unpreconditioned(A); }
    PressurePreconditioner diagonal() const { return diagonal_scaling(A); }
    PressurePreconditioner multigrid(const ParticleMultigrid& options) const { return constraint_multigrid(options)(A); }
    static ParticleMultigrid levels() { return constraint_levels; }
};

/// Linear system of the published pressure equation for the same step.
struct PoissonSystem {
    static constexpr const char* form = "published";
    PressureMatrix A;
    Column<Real> b;
    double step_residual = 0;
    explicit PoissonSystem(State& s) {
        World& w = s.w;
        PressureOptions options;
        options.solid_factor = continued_lattice_factor(w.step.kernel, w.step.support, w.step.spacing);
        options.limits = {1e-30, 1};
        PoissonPressure pressure(options, [this](const PressureMatrix& matrix) {
            A = matrix;
            return PressurePreconditioner{[this, inner = jacobi(A)](Span<const Real> r, Span<Real> z) {
                if (b.empty()) b.assign(r.begin(), r.end());
                inner(r, z);
            }};
        });
        Column<Vec3> u = s.u;
        Column<Real> p(s.size(), 0);
        StepReport report;
        const auto fluid = [&]<class F>(F) { return Read<F>{std::as_const(w.fluid).template column<F>()}; };
        pressure(w.context(), report, fluid(field::role{}), fluid(field::density{}), Update<field::velocity>{{u}},
                 Update<field::pressure>{{p}});
        double unknowns = 0, source = 0;
        for (std::size_t i = 0; i < b.size(); ++i) unknowns += A.unknown[i], source += static_cast<double>(b[i]) * b[i];
        const double dt = w.step.dt, density = std::sqrt(unknowns) * static_cast<double>(w.step.volume) * w.step.rest_density / (dt * dt);
        step_residual = 1e-3 * std::min(density, 10 * std::sqrt(source));
    }
    PressurePreconditioner none() const { return poisson_unpreconditioned(A); }
    PressurePreconditioner diagonal() const { return jacobi(A); }
    PressurePreconditioner multigrid(const ParticleMultigrid& options) const { return poisson_multigrid(options)(A); }
    static ParticleMultigrid levels() { return poisson_levels; }
};

struct Measured {
    int iterations = 0, levels = 1;
    double set_up = 0, solve = 0;  ///< CPU s
    double bytes = 0;
    bool converged = false;
    double error = 0;  ///< of the solution, relative, in the energy norm; for the constraint, the error of the velocities
    double total() const { return set_up + solve; }
};

/// sqrt(x.A x)
template <class System>
double energy_norm(const System& s, const Column<Real>& x) {
    Column<Real> Ax(x.size());
    s.A.multiply(x, Ax);
    return std::sqrt(std::max(0.0, dot<Real>(x, Ax)));
}

/// Solves the system from zero. @param residual absolute tolerance @param exact the solution, for the error; empty if unknown
template <class System, class MakePreconditioner>
Measured measure(const System& s, double residual, const MakePreconditioner& make, const Column<Real>& exact = {}) {
    Measured m;
    double start = cpu_seconds();
    const PressurePreconditioner M = make();
    m.set_up = cpu_seconds() - start;
    start = cpu_seconds();
    Column<Real> x(s.b.size(), 0);
    const SolveReport report =
        conjugate_gradients<Real>([&](Span<const Real> in, Span<Real> out) { s.A.multiply(in, out); }, M, Span<const Real>(s.b),
                                  Span<Real>(x), SolveLimits{1, 5000}, ResidualNorm::euclidean, residual);
    m.solve = cpu_seconds() - start;
    m.iterations = report.iterations;
    m.converged = report.converged;
    m.levels = M.levels;
    m.bytes = static_cast<double>(M.bytes);
    if (!exact.empty()) {
        for (std::size_t i = 0; i < x.size(); ++i) x[i] -= exact[i];
        m.error = energy_norm(s, x) / energy_norm(s, exact);
    }
    return m;
}

void print_measured(const auto& system, double factor, Index particles, double residual, const char* preconditioner, const Measured& m) {
    print_csv(system.form, particles, factor, residual, preconditioner, m.iterations, m.converged ? 1 : 0, m.total(), m.error, m.set_up,
              m.levels, m.bytes / static_cast<double>(particles));
}

/// @param factor time step over dt @param dt time step at CFL 0.4 [s]
template <class System>
void print_preconditioners(State& s, double factor, Real dt) {
    s.predict(factor, dt);
    const System system(s);
    const double norm = std::sqrt(dot<Real>(system.b, system.b));
    Column<Real> exact(system.b.size(), 0);
    conjugate_gradients<Real>([&](Span<const Real> in, Span<Real> out) { system.A.multiply(in, out); }, system.multigrid(System::levels()),
                              Span<const Real>(system.b), Span<Real>(exact), SolveLimits{1, 400}, ResidualNorm::euclidean, 1e-5 * norm);
    for (const double residual : {system.step_residual, 1e-3 * norm}) {
        const auto print = [&](const char* name, const auto& make) {
            print_measured(system, factor, s.size(), residual / norm, name, measure(system, residual, make, exact));
        };
        print("none", [&] { return system.none(); });
        print("diagonal", [&] { return system.diagonal(); });
        print("multigrid", [&] { return system.multigrid(System::levels()); });
    }
}

template <class System>
void print_hierarchies(State& s, Real dt) {
    s.predict(1, dt);
    const System system(s);
    const double norm = std::sqrt(dot<Real>(system.b, system.b)), residual = std::min(system.step_residual, 0.05 * norm);
    for (const Real cell : {Real(2), Real(3), Real(4), Real(5), Real(7)})
        for (const bool smoothed : {false, true})
            for (const bool additive : {true, false}) {
                const Measured m = measure(system, residual, [&] { return system.multigrid({cell, additive, {smoothed, 250, 20}}); });
                print_csv(System::form, cell, smoothed ? "smoothed" : "constants", additive ? "additive" : "V-cycle", m.iterations,
                          m.set_up, m.total());
            }
}

struct Keys {
    std::string form = "constraint";
    int layers = 29, steps = 20;
};

/// Adds a subcommand that runs `of_constraint` or `of_poisson` on the half-filled box after some steps.
void add(CLI::App& program, const char* name, const char* what, const auto& print_header, void (*of_constraint)(State&, Real),
         void (*of_poisson)(State&, Real)) {
    const auto keys = std::make_shared<Keys>();
    CLI::App* app = program.add_subcommand(name, what);
    app->add_option("--form", keys->form)->check(CLI::IsMember({"constraint", "published"}))->capture_default_str();
    app->add_option("--layers", keys->layers, "layers of particles across the depth (14: 1.1e4 particles, 29: 1e5, 63: 1e6)")
        ->capture_default_str();
    app->add_option("--steps", keys->steps, "steps before the measured one")->capture_default_str();
    app->callback([=] {
        State state(read_scene_text(half_filled_box(keys->layers, keys->form), "half_filled_box.toml"), keys->steps);
        print_header();
        (keys->form == "constraint" ? of_constraint : of_poisson)(state, state.w.step.dt);
    });
}

template <class System>
void print_two_steps(State& s, Real dt) {
    for (const double factor : {1.0, 4.0}) print_preconditioners<System>(s, factor, dt);
}

}  // namespace

void add_pressure_solves(CLI::App& program) {
    add(
        program, "pressure_preconditioners",
        "iterations, CPU seconds and error without preconditioner, with the diagonal and with multigrid",
        [] {
            print_csv("form", "particles", "factor", "residual", "preconditioner", "iterations", "converged", "seconds", "error",
                      "set_up_seconds", "levels", "bytes");
        },
        print_two_steps<ConstraintSystem>, print_two_steps<PoissonSystem>);
    add(
        program, "pressure_hierarchies", "multigrid with other first levels, interpolations and cycles",
        [] { print_csv("form", "cell", "interpolation", "cycle", "iterations", "set_up_seconds", "seconds"); },
        print_hierarchies<ConstraintSystem>, print_hierarchies<PoissonSystem>);
}

}  // namespace whorl

/// The preconditioners of the pressure solves on the systems of a half-filled box under tilted gravity (docs/pressure.md).
#include <fmt/format.h>

#include <cmath>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/pressure/pressure_multigrid.h"
#include "engine/particles/search.h"
#include "engine/scene/read.h"
#include "engine/sim/simulation.h"
#include "tools/studies/studies.h"

namespace whorl {
namespace {

/// A cube of 1 m, half full, gravity 20 degrees off its axis: two layers of water to the metre and a spacing of 1/(2 layers).
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
form = "{}"
[[block]]
shape = "box"
min = [0, 0, 0]
max = [1, 0.5, 1]
[[solid]]
shape = "box"
inside = true
min = [0, 0, 0]
max = [1, 1, 1]
)toml",
                       0.5 / layers, form);
}

/// The state of a run after some steps, and the velocities that the next step would hand to its pressure solve.
struct State {
    Simulation simulation;
    World& w;
    Column<Vec3> u;
    explicit State(const Scene& scene, int steps) : simulation(scene, make_plan(scene)), w(const_cast<World&>(simulation.world())) {
        for (int k = 0; k < steps; ++k) simulation.step(scene.time.end);
        const auto x = std::as_const(w.fluid).column<field::position>();
        NeighbourSearch fluid, solid;
        fluid.find(x, w.step.support, w.step.domain, w.fluid_pairs);
        solid.find(x, w.solid_particles.position, w.step.support, w.step.domain, w.solid_pairs);
    }
    void predict(double factor, Real dt) {
        w.step.dt = dt * static_cast<Real>(factor);
        const auto now = w.fluid.column<field::velocity>();
        u.assign(now.begin(), now.end());
        for (Vec3& one : u) one += w.step.dt * w.step.gravity;
    }
    Index size() const { return w.fluid.size(); }
};

/// What the constraint's step solves first: all that press or are about full, the source b, the residual of a density error of rho_0 a
/// step.
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
        D.build(WallImage(w.step.kernel, w.step.support, w.step.spacing), w.fluid_pairs, w.solid_pairs, w.solid_particles, w.step,
                Read<field::role>{role}, Read<field::velocity>{s.u}, rho, b);
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

/// The published rows of the same step.
struct PoissonSystem {
    static constexpr const char* form = "poisson";
    PressureMatrix A;
    Column<Real> b;
    double step_residual = 0;
    explicit PoissonSystem(State& s) {
        World& w = s.w;
        PoissonPressureOptions options;
        options.solid_factor = continued_lattice_factor(w.step.kernel, w.step.support, w.step.spacing);
        options.limits = {1e-30, 1};
        options.preconditioner = [this](const PressureMatrix& matrix) {
            A = matrix;
            return PressurePreconditioner{[this, inner = jacobi(A)](Span<const Real> r, Span<Real> z) {
                if (b.empty()) b.assign(r.begin(), r.end());
                inner(r, z);
            }};
        };
        PoissonPressure pressure(options);
        Column<Vec3> u = s.u;
        Column<Real> p(s.size(), 0);
        StepReport report;
        const auto fluid = [&]<class F>(F) { return Read<F>{std::as_const(w.fluid).template column<F>()}; };
        pressure(w.fluid_pairs, w.solid_pairs, w.solid_particles, w.step, report, fluid(field::role{}), fluid(field::density{}),
                 Update<field::velocity>{{u}}, Update<field::pressure>{{p}});
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
    double error = 0;  ///< of the solution in the energy norm, relative: in the constraint that of the velocities
    double total() const { return set_up + solve; }
};

/// sqrt(x.A x)
template <class System>
double energy_norm(const System& s, const Column<Real>& x) {
    Column<Real> Ax(x.size());
    s.A.multiply(x, Ax);
    return std::sqrt(std::max(0.0, dot<Real>(x, Ax)));
}

/// @param residual absolute @param exact the solution, or nothing
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

std::string cell(const Measured& m) {
    return fmt::format("{}{} | {:.3g} | {:.2g}", m.iterations, m.converged ? "" : "+", 1e3 * m.total(), 100 * m.error);
}

template <class System>
void compare(std::string& table, State& s, double factor, Real dt) {
    s.predict(factor, dt);
    const System system(s);
    const double norm = std::sqrt(dot<Real>(system.b, system.b));
    Column<Real> exact(system.b.size(), 0);
    conjugate_gradients<Real>([&](Span<const Real> in, Span<Real> out) { system.A.multiply(in, out); }, system.multigrid(System::levels()),
                              Span<const Real>(system.b), Span<Real>(exact), SolveLimits{1, 400}, ResidualNorm::euclidean, 1e-5 * norm);
    for (const bool of_step : {true, false}) {
        const double residual = of_step ? system.step_residual : 1e-3 * norm;
        const Measured none = measure(
            system, residual, [&] { return system.none(); }, exact);
        const Measured diagonal = measure(
            system, residual, [&] { return system.diagonal(); }, exact);
        const Measured levels = measure(
            system, residual, [&] { return system.multigrid(System::levels()); }, exact);
        table += fmt::format("| {} | {} | {:g} | {:.1e} | {} | {} | {} | {:.3g} | {} | {:.0f} | {:.1f} |\n", System::form, s.size(), factor,
                             residual / norm, cell(none), cell(diagonal), cell(levels), 1e3 * levels.set_up, levels.levels,
                             levels.bytes / static_cast<double>(s.size()), diagonal.total() / levels.total());
    }
}

template <class System>
void hierarchies(std::string& table, State& s, Real dt) {
    s.predict(1, dt);
    const System system(s);
    const double norm = std::sqrt(dot<Real>(system.b, system.b)), residual = std::min(system.step_residual, 0.05 * norm);
    for (const Real cell_size : {Real(2), Real(3), Real(4), Real(5), Real(7)})
        for (const bool smoothed : {false, true}) {
            table += fmt::format("| {} | {} d | {} |", System::form, cell_size, smoothed ? "smoothed" : "constants");
            for (const bool additive : {true, false}) {
                const Measured m = measure(system, residual, [&] { return system.multigrid({cell_size, additive, {smoothed, 250, 20}}); });
                table += fmt::format(" {} | {:.3g} | {:.3g} |", m.iterations, 1e3 * m.set_up, 1e3 * m.total());
            }
            table += "\n";
        }
}

Scene scene(int layers, const std::string& form) { return read_scene_text(half_filled_box(layers, form), "half_filled_box.toml"); }

constexpr const char* header =
    "| form | particles | step over CFL 0.4 | residual | none | ms | error % | diagonal | ms | error % | multigrid | ms | error % | of it "
    "set-up | levels | bytes a particle | times "
    "faster |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

/// @param layers across the depth: 14 make 1.1e4 particles, 29 1e5, 63 1e6
std::string preconditioners(std::initializer_list<std::pair<int, int>> layers_and_steps) {
    set_threads(1);
    std::string table = header;
    for (const auto& [layers, steps] : layers_and_steps) {
        State s(scene(layers, "constraint"), steps);
        const Real dt = s.w.step.dt;
        for (const double factor : {1.0, 4.0}) compare<ConstraintSystem>(table, s, factor, dt);
    }
    for (const auto& [layers, steps] : layers_and_steps) {
        State s(scene(layers, "poisson"), steps);
        const Real dt = s.w.step.dt;
        for (const double factor : {1.0, 4.0}) compare<PoissonSystem>(table, s, factor, dt);
    }
    return table;
}

}  // namespace

std::string preconditioner_table() { return preconditioners({{7, 10}, {14, 16}, {29, 20}}); }
std::string preconditioner_table_large() { return preconditioners({{63, 4}}); }

std::string hierarchy_table() {
    set_threads(1);
    std::string table =
        "| form | cells | coarse interpolation | additive: iterations | set-up ms | ms | V-cycle: iterations | set-up ms | ms "
        "|\n|---|---|---|---|---|---|---|---|---|\n";
    State constraint(scene(29, "constraint"), 20);
    hierarchies<ConstraintSystem>(table, constraint, constraint.w.step.dt);
    State poisson(scene(29, "poisson"), 20);
    hierarchies<PoissonSystem>(table, poisson, poisson.w.step.dt);
    return table;
}

std::string thread_table() {
    std::string table = "| form | threads | set-up ms | solve ms | faster |\n|---|---|---|---|---|\n";
    const auto rows = [&](auto& system, const char* form) {
        double one = 0;
        for (const int count : {1, 2}) {
            set_threads(count);
            double best_set_up = 1e30, best_solve = 1e30;
            for (int k = 0; k < 5; ++k) {  // wall time, the best of five: other programs may run
                double start = wall_seconds();
                const PressurePreconditioner M = system.multigrid(system.levels());
                best_set_up = std::min(best_set_up, wall_seconds() - start);
                Column<Real> x(system.b.size(), 0);
                start = wall_seconds();
                conjugate_gradients<Real>([&](Span<const Real> in, Span<Real> out) { system.A.multiply(in, out); }, M,
                                          Span<const Real>(system.b), Span<Real>(x), SolveLimits{1, 500}, ResidualNorm::euclidean,
                                          system.step_residual);
                best_solve = std::min(best_solve, wall_seconds() - start);
            }
            if (count == 1) one = best_set_up + best_solve;
            table += fmt::format("| {} | {} | {:.3g} | {:.3g} | {:.2f} |\n", form, count, 1e3 * best_set_up, 1e3 * best_solve,
                                 one / (best_set_up + best_solve));
        }
    };
    set_threads(1);
    State s(scene(29, "constraint"), 20);
    s.predict(1, s.w.step.dt);
    ConstraintSystem constraint(s);
    rows(constraint, "constraint");
    set_threads(1);
    State t(scene(29, "poisson"), 20);
    t.predict(1, t.w.step.dt);
    PoissonSystem poisson(t);
    rows(poisson, "poisson");
    set_threads(0);
    return table;
}

}  // namespace whorl

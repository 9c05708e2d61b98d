/// The viscous preconditioners, measured on a thread and its pile.
#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "engine/models/viscosity/coupled/coupled_solve.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/particles/sort.h"
#include "engine/scene/names.h"
#include "tests/support/world.h"
#include "tools/measure/solver/subcommands.h"

namespace whorl {
namespace {

using test::TestWorld;

constexpr double d = 0.01, density = 1000;

/// A pile on a plate, and a thread above it that hangs from a nozzle.
/// @param scale size; 1: four thousand particles @param uneven largest random displacement from the lattice along each axis [d]
/// @param stuck whether the role of the lowest fluid particles keeps them at rest, for a solve without boundary particles
TestWorld coil(double scale, double uneven, double nu, const std::vector<Stage>& stages, bool stuck) {
    const double pile = 11 * scale * d, height = 5.5 * scale * d, thread = 4 * scale * d, top = 34 * scale * d;
    TestWorld w(d, 2,
                Domain{Vec3(Real(-2 * pile), Real(-8 * d), Real(-2 * pile)), Vec3(Real(2 * pile), Real(2 * top), Real(2 * pile)), {}});
    w.use(stages);
    w.add_wall(1, +1, 0);
    w.place(Vec3(Real(-pile), 0, Real(-pile)), Vec3(Real(pile), Real(top), Real(pile)), density * nu,
            [&](const Vec3& x) { return Vec3(Real(std::sin(9 * x.y() / top)), Real(-x.y() / top), Real(std::cos(9 * x.y() / top))); });
    RandomNumbers random(1);
    std::vector<Index> kept;
    const auto x = w.column<field::position>();
    const auto role = w.column<field::role>();
    for (Index i = 0; i < w.world.fluid.size(); ++i) {
        Vec3& one = x[i];
        const double r = std::hypot(one.x(), one.z());
        if (r < (one.y() < height ? pile : thread)) kept.push_back(i);
        role[i] = one.y() > top - 3 * d ? -1 : 0;
        if (stuck && one.y() < d) role[i] = -1, w.column<field::velocity>()[i].setZero();
        one += Real(2 * uneven * d) * (Vec3(Real(random()), Real(random()), Real(random())) - Vec3::Constant(Real(0.5)));
    }
    w.world.fluid.gather(kept);
    w.world.fluid.gather(curve_order(std::as_const(w.world.fluid).column<field::position>(), w.world.step.support));
    w.world.step.gravity.setZero();
    return w;
}

struct Cost {
    double cold = 0, warm = 0, milliseconds = 0;  ///< iterations of the first step; mean iterations, CPU ms of later steps
    double error = 0;                             ///< relative error of the velocity after the first solve
    Index particles = 0;
};

std::vector<Vec3> velocities(TestWorld& w) {
    const auto u = w.column<field::velocity>();
    return {u.begin(), u.end()};
}

struct Solver {
    std::vector<Stage> (*stages)(ViscousPreconditioner, SolveLimits);
    bool holds_by_role;
};

/// Velocity after the first step, solved to a tolerance of 1e-6, far below that of a run.
std::vector<Vec3> exact(double scale, double uneven, double K, const Solver& solver) {
    TestWorld w = coil(scale, uneven, 1, solver.stages(ViscousPreconditioner::two_level, {1e-6, 300}), solver.holds_by_role);
    w.step(K * d * d);
    return velocities(w);
}

/// Cost of the first step, and mean cost of the next four (two above 200,000 particles). Before each of these, the particles move by up to
/// 0.01 d along each axis. Their velocity changes by 5 % of the rms speed downward and up to 1 % at random.
Cost cost(double scale, double uneven, double K, ViscousPreconditioner preconditioner, const Solver& solver,
          const std::vector<Vec3>& exact_velocity) {
    TestWorld w = coil(scale, uneven, 1, solver.stages(preconditioner, {3e-3, 5000}), solver.holds_by_role);
    RandomNumbers random(2);
    const auto noise = [&] { return Vec3(Vec3(Real(random()), Real(random()), Real(random())) - Vec3::Constant(Real(0.5))); };
    Cost c;
    c.particles = w.world.fluid.size();
    const double dt = K * d * d;
    const int steps = c.particles > 200000 ? 2 : 4;
    for (int s = 0; s <= steps; ++s) {
        const auto u = w.column<field::velocity>();
        const auto x = w.column<field::position>();
        if (s > 0) {
            double speed = 0;
            for (const Vec3& one : u) speed += one.squaredNorm();
            speed = std::sqrt(speed / static_cast<double>(u.size()));
            for (std::size_t i = 0; i < u.size(); ++i) {
                x[i] += Real(0.02 * d) * noise();
                if (w.column<field::role>()[i] == 0) u[i] += Real(speed) * (Vec3(0, Real(-0.05), 0) + Real(0.02) * noise());
            }
        }
        w.world.step.at_frame_time = s == 0;
        const double before = cpu_seconds();
        w.step(dt);
        const double spent = 1e3 * (cpu_seconds() - before);
        const SolveReport& solve = w.world.report.solves.at(0).report;
        if (s > 0) {
            c.warm += solve.iterations / double(steps), c.milliseconds += spent / steps;
            continue;
        }
        c.cold = solve.iterations;
        double wrong = 0, all = 0;
        const std::vector<Vec3> now = velocities(w);
        for (std::size_t i = 0; i < now.size(); ++i)
            wrong += (now[i] - exact_velocity[i]).squaredNorm(), all += exact_velocity[i].squaredNorm();
        c.error = std::sqrt(wrong / all);
    }
    return c;
}

std::vector<Stage> full(ViscousPreconditioner p, SolveLimits limits) {
    ViscosityOptions o;
    o.limits = limits;
    o.preconditioner = p;
    return {make_stage("viscosity", "viscosity", FullViscosity(o))};
}

std::vector<Stage> coupled(ViscousPreconditioner p, SolveLimits limits) {
    CoupledOptions o;
    o.limits = limits;
    o.diagonal = p != ViscousPreconditioner::none;
    if (p != ViscousPreconditioner::two_level) o.fewest_for_coarse = std::numeric_limits<int>::max();
    const auto system = std::make_shared<CoupledSystem>(o);
    return {make_stage("rows", "neighbours", CoupledNeighbourhood{system}), make_stage("solve", "pressure", CoupledSolve{system})};
}

}  // namespace

void add_viscous_preconditioners(CLI::App& program) {
    struct Keys {
        std::string solve = "full";
        double scale = 1, uneven = 0.05;
        std::vector<double> K{1, 100, 1250, 1e4};
        std::vector<std::string> preconditioners{"none", "block_jacobi", "two_level"};
    };
    const auto keys = std::make_shared<Keys>();
    CLI::App* app = program.add_subcommand("viscous_preconditioners",
                                           "iterations, error and time of the viscous solves by preconditioner, for a thread and its pile");
    app->add_option("--solve", keys->solve)->check(CLI::IsMember({"full", "coupled"}))->capture_default_str();
    app->add_option("--scale", keys->scale, "1: four thousand particles, 2.35: fifty thousand, 5.05: half a million")
        ->capture_default_str();
    app->add_option("--uneven", keys->uneven, "largest random displacement from the lattice [d]")->capture_default_str();
    app->add_option("--K", keys->K, "nu dt/d^2")->capture_default_str();
    app->add_option("--preconditioner", keys->preconditioners)->check(CLI::IsMember(keys->preconditioners))->capture_default_str();
    app->callback([keys] {
        const Solver solver = keys->solve == "full" ? Solver{full, false} : Solver{coupled, true};
        print_csv("particles", "K", "preconditioner", "cold", "warm", "error", "milliseconds");
        for (const double K : keys->K) {
            const std::vector<Vec3> solution = exact(keys->scale, keys->uneven, K, solver);
            for (const auto& [preconditioner, name] : choices(ViscousPreconditioner{})) {
                if (std::find(keys->preconditioners.begin(), keys->preconditioners.end(), name) == keys->preconditioners.end()) continue;
                const Cost c = cost(keys->scale, keys->uneven, K, preconditioner, solver, solution);
                print_csv(c.particles, K, name, c.cold, c.warm, c.error, c.milliseconds);
            }
        }
    });
}

}  // namespace whorl

/// Time [ns] per particle of a product with the operator of each implicit solve, on a block of fluid on a floor. The coupled solve uses a
/// thread instead. Particles are sorted along the space-filling curve, as in a run.
#include <benchmark/benchmark.h>

#include <numbers>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/density_rate.h"
#include "engine/models/pressure/poisson.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/particles/sort.h"
#include "engine/sph/density.h"
#include "tests/support/coupled_world.h"
#include "tests/support/world.h"

using namespace whorl;

namespace {

constexpr double d = 2e-3;

/// About n particles under gravity, displaced from a lattice by up to a twentieth of the spacing along each axis.
struct Block : test::TestWorld {
    Real factor = continued_lattice_factor(KernelKind::cubic, Real(2 * d), Real(d));

    explicit Block(Index n) : TestWorld(d, 2, Domain{Vec3::Zero(), Vec3::Constant(Real((std::lround(std::cbrt(n)) + 4) * d)), {}}) {
        const auto side = static_cast<double>(std::lround(std::cbrt(n)));
        use({make_stage("density", "density", Density{factor}), make_stage("gravity", "move", Gravity{}),
             make_stage("kick", "move", Kick{}), make_stage("viscosity", "viscosity", FullViscosity({})),
             make_stage("pressure", "pressure", PoissonPressure({}))});
        world.step.gravity = Vec3(0, Real(-9.81), 0);
        world.step.dt = Real(1e-3);
        add_wall(1, +1, 0);
        RandomNumbers random(1);
        place(Vec3::Zero(), Vec3::Constant(Real(side * d)), 1, [&](const Vec3& x) { return Vec3(x.y(), Real(random()) * Real(1e-3), 0); });
        for (Vec3& x : column<field::position>()) x += Real(0.05 * d) * Vec3(Real(random()), Real(random()), Real(random()));
        world.fluid.gather(curve_order(std::as_const(world.fluid).column<field::position>(), world.step.support));
        find_pairs();
    }
    template <class F>
    Read<F> read() {
        return {std::as_const(world.fluid).template column<F>()};
    }
};

void report(benchmark::State& state, double particles, double pairs) {
    using benchmark::Counter;
    const auto nanoseconds_each = [&](double count) {
        return Counter(count * 1e-9 * static_cast<double>(state.iterations()), Counter::kIsRate | Counter::kInvert);
    };
    state.counters["ns/particle"] = nanoseconds_each(particles);
    state.counters["ns/pair"] = nanoseconds_each(pairs);
    state.counters["neighbours"] = pairs / particles;
    state.counters["threads"] = threads();
}
void report(benchmark::State& state, const Block& block) {
    report(state, static_cast<double>(block.world.fluid.size()), static_cast<double>(block.world.fluid_pairs.other.size()));
}

void viscous_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    ViscosityOptions options;
    options.solid_factor = block.factor;
    ViscousOperator A;
    A.set_up(options, block.world.context(), block.read<field::role>(), block.read<field::viscosity>());
    const auto u = block.column<field::velocity>();
    std::vector<Vec3> Au(u.size());
    for (auto _ : state) {
        A.multiply(u, Au);
        benchmark::ClobberMemory();
    }
    report(state, block);
}

void pressure_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    World& w = block.world;
    Density{block.factor}(w.context(), {block.column<field::density>()});
    PressureOptions options;
    options.solid_factor = block.factor;
    PoissonPressure pressure(options);
    pressure(w.context(), w.report, block.read<field::role>(), block.read<field::density>(), {{block.column<field::velocity>()}},
             {{block.column<field::pressure>()}});
    const std::vector<Real> p(w.fluid.size(), 1);
    std::vector<Real> Ap(p.size());
    for (auto _ : state) {
        pressure.matrix().multiply(p, Ap);
        benchmark::ClobberMemory();
    }
    report(state, block);
}

/// A product with D's transpose and one with D, as in an iteration of the constraint.
void constraint_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    World& w = block.world;
    DensityRate D;
    const std::size_t n = static_cast<std::size_t>(w.fluid.size());
    Column<Real> rho(n), rate(n), q(n, 1);
    D.build(WallImage(w.step.kernel, w.step.support, w.step.spacing), w.context(), block.read<field::role>(), block.read<field::velocity>(),
            rho, rate);
    Column<Padded> force(n);
    const std::vector<char> all(n, 1);
    for (auto _ : state) {
        D.transposed(q, force);
        D.apply(force, all, rate);
        benchmark::ClobberMemory();
    }
    report(state, block);
}

void coupled_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    constexpr Real radius = Real(2.5 * d), spacing = Real(d);
    const Real length = static_cast<Real>(state.range(0)) * spacing * spacing * spacing / (std::numbers::pi_v<Real> * radius * radius);
    test::CoupledWorld thread(test::blue_noise_cylinder(radius, length, spacing), spacing, 1);
    thread.solve_only(Real(4e-3));
    std::vector<Vec3> y(thread.velocity().size());
    for (auto _ : state) {
        thread.system->form.apply(thread.velocity(), y);
        benchmark::ClobberMemory();
    }
    report(state, static_cast<double>(y.size()), static_cast<double>(thread.system->rows.pairs));
}

}  // namespace

// Arguments: particles, threads.
BENCHMARK(viscous_product)->ArgsProduct({{3000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(constraint_product)->ArgsProduct({{3000, 30000, 200000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(pressure_product)->ArgsProduct({{3000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(coupled_product)->ArgsProduct({{3000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);

/// ns per particle of the parts of the implicit solves: a product with the operator of the full viscosity and with the pressure matrix,
/// and their set-up once a step. A block of fluid on a floor, in the order of the curve, as in a run.
#include <benchmark/benchmark.h>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/density_rate.h"
#include "engine/models/pressure/poisson.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/particles/sort.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

using namespace whorl;

namespace {

constexpr double d = 2e-3;

/// About n particles, a twentieth of the spacing off their lattice, under gravity.
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
        CurveSort curve;
        world.fluid.gather(curve.order(std::as_const(world.fluid).column<field::position>(), world.step.support));
        find_pairs();
    }
    template <class F>
    Read<F> read() {
        return {std::as_const(world.fluid).template column<F>()};
    }
};

void per_particle(benchmark::State& state, Block& block) {
    const auto particles = static_cast<double>(block.world.fluid.size());
    state.counters["ns/particle"] = benchmark::Counter(particles * 1e-9 * static_cast<double>(state.iterations()),
                                                       benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    const auto pairs = static_cast<double>(block.world.fluid_pairs.other.size());
    state.counters["ns/pair"] = benchmark::Counter(pairs * 1e-9 * static_cast<double>(state.iterations()),
                                                   benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["neighbours"] = pairs / particles;
    state.counters["threads"] = threads();
}

void set_up(ViscousOperator& A, Block& block) {
    FullViscosityOptions options;
    options.solid_factor = block.factor;
    World& w = block.world;
    A.set_up(options, w.surroundings(), block.read<field::role>(), block.read<field::viscosity>());
}

void viscous_set_up(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    ViscousOperator A;
    for (auto _ : state) set_up(A, block);
    per_particle(state, block);
}

void viscous_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    ViscousOperator A;
    set_up(A, block);
    const auto u = block.column<field::velocity>();
    std::vector<Vec3> Au(u.size());
    for (auto _ : state) {
        A.multiply(u, Au);
        benchmark::ClobberMemory();
    }
    per_particle(state, block);
}

/// The whole stage with no iteration of the solver: classes, matrix, right-hand side, the push of the pressure.
void pressure_set_up(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    World& w = block.world;
    Density{block.factor}(w.surroundings(), {block.column<field::density>()});
    PoissonPressureOptions options;
    options.limits.max_iterations = 0;
    options.solid_factor = block.factor;
    PoissonPressure pressure(options);
    for (auto _ : state) {
        w.report = {};
        pressure(w.surroundings(), w.report, block.read<field::role>(), block.read<field::density>(), {{block.column<field::velocity>()}},
                 {{block.column<field::pressure>()}});
    }
    per_particle(state, block);
}

void pressure_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    World& w = block.world;
    Density{block.factor}(w.surroundings(), {block.column<field::density>()});
    PoissonPressureOptions options;
    options.solid_factor = block.factor;
    PoissonPressure pressure(options);
    pressure(w.surroundings(), w.report, block.read<field::role>(), block.read<field::density>(), {{block.column<field::velocity>()}},
             {{block.column<field::pressure>()}});
    const std::vector<Real> p(w.fluid.size(), 1);
    std::vector<Real> Ap(p.size());
    for (auto _ : state) {
        pressure.matrix().multiply(p, Ap);
        benchmark::ClobberMemory();
    }
    per_particle(state, block);
}

/// A product with D and with its transpose: an iteration of the constraint.
void constraint_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Block block(static_cast<Index>(state.range(0)));
    World& w = block.world;
    DensityRate D;
    const std::size_t n = static_cast<std::size_t>(w.fluid.size());
    Column<Real> rho(n), rate(n), q(n, 1);
    D.build(WallImage(w.step.kernel, w.step.support, w.step.spacing), w.surroundings(), block.read<field::role>(),
            block.read<field::velocity>(), rho, rate);
    Column<Padded> force(n);
    const std::vector<char> all(n, 1);
    for (auto _ : state) {
        D.transposed(q, force);
        D.apply(force, all, rate);
        benchmark::ClobberMemory();
    }
    per_particle(state, block);
}

}  // namespace

// Particles, threads.
BENCHMARK(viscous_set_up)->ArgsProduct({{3000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(viscous_product)->ArgsProduct({{3000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(pressure_set_up)->ArgsProduct({{3000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(constraint_product)->ArgsProduct({{3000, 30000, 200000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(pressure_product)->ArgsProduct({{3000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);

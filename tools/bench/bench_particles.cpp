/// Time [ns] per particle of the loops that every model needs: neighbour search, sort, density.
#include <benchmark/benchmark.h>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/particles/search.h"
#include "engine/particles/sort.h"
#include "engine/sph/density.h"

using namespace whorl;

namespace {

/// A jittered block of about n particles, sorted along the space-filling curve, as in a run.
struct Block {
    static constexpr Real d = Real(2e-3);
    std::vector<Vec3> x;
    explicit Block(Index n) {
        RandomNumbers random(1);
        const int side = static_cast<int>(std::lround(std::cbrt(n)));
        for (int k = 0; k < side * side * side; ++k) {
            const Vec3d noise(random(), random(), random());
            x.push_back(d * (Vec3d(k % side, k / side % side, k / side / side) + 0.5 * noise).cast<Real>());
        }
        std::vector<Vec3> sorted;
        for (Index i : curve_order(x, 2 * d)) sorted.push_back(x[i]);
        x = sorted;
    }
};

void per_particle(benchmark::State& state, std::size_t particles, double neighbours = 0) {
    state.counters["ns/particle"] = benchmark::Counter(static_cast<double>(particles) * 1e-9 * static_cast<double>(state.iterations()),
                                                       benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    if (neighbours > 0) state.counters["neighbours"] = neighbours;
    state.counters["threads"] = threads();
}

double mean_neighbours(const Pairs& pairs) { return static_cast<double>(pairs.other.size()) / pairs.size(); }

void search(benchmark::State& state) {
    const Block block(static_cast<Index>(state.range(0)));
    set_threads(static_cast<int>(state.range(2)));
    NeighbourSearch neighbours;
    FluidPairs pairs;
    const Real support = Real(static_cast<double>(state.range(1))) * Real(0.1) * Block::d;
    for (auto _ : state) neighbours.find(block.x, support, {}, pairs);
    per_particle(state, block.x.size(), mean_neighbours(pairs));
}

void sort(benchmark::State& state) {
    Block block(static_cast<Index>(state.range(0)));
    set_threads(static_cast<int>(state.range(1)));
    for (auto _ : state) benchmark::DoNotOptimize(curve_order(block.x, 2 * Block::d).data());
    per_particle(state, block.x.size());
}

template <KernelKind kind>
void density(benchmark::State& state) {
    const Block block(static_cast<Index>(state.range(0)));
    set_threads(static_cast<int>(state.range(2)));
    FluidPairs pairs;
    Solids solids;
    BoundaryParticles boundary;
    StepContext step;
    step.support = Real(static_cast<double>(state.range(1))) * Real(0.1) * Block::d;
    step.kernel = kind;
    step.rest_density = 1000;
    step.mass = 1000 * Block::d * Block::d * Block::d;
    NeighbourSearch().find(block.x, step.support, {}, pairs);
    std::vector<Real> rho(block.x.size());
    for (auto _ : state) {
        sum_density({pairs, {}, solids, boundary, step}, 1, {}, rho);
        benchmark::ClobberMemory();
    }
    per_particle(state, block.x.size(), mean_neighbours(pairs));
}

}  // namespace

// Arguments: particles, ten times support over spacing (not for sort), threads.
BENCHMARK(search)->ArgsProduct({{3000, 30000, 300000}, {20, 30}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(sort)->ArgsProduct({{3000, 30000, 300000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(density, KernelKind::cubic)
    ->ArgsProduct({{3000, 30000, 300000}, {20, 30}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(density, KernelKind::wendland_c2)->ArgsProduct({{30000}, {30}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);

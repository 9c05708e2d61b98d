/// Limits of the machine, as a reference for the kernels' times: bytes per second from memory, multiply-adds per second in
/// registers.
#include <benchmark/benchmark.h>

#include "engine/core/column.h"
#include "engine/core/parallel.h"

using namespace whorl;

namespace {

/// Sums a column of the given size [MB]: 1 stays in a core's cache, 256 comes from memory.
void read_memory(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    const Column<Real> values(static_cast<std::size_t>(state.range(0)) * (1 << 20) / sizeof(Real), Real(1));
    constexpr Index block = 1 << 14;
    const auto n = static_cast<Index>(values.size());
    std::vector<Real> sums(static_cast<std::size_t>(n / block + 1));
    for (auto _ : state) {
        parallel_blocks(n, block, [&](Index begin, Index end) {
            Real sum = 0;
            for (Index i = begin; i < end; ++i) sum += values[static_cast<std::size_t>(i)];
            sums[static_cast<std::size_t>(begin / block)] = sum;
        });
        benchmark::DoNotOptimize(sums.data());
    }
    state.counters["GB/s"] = benchmark::Counter(1e-9 * static_cast<double>(n) * sizeof(Real) * static_cast<double>(state.iterations()),
                                                benchmark::Counter::kIsRate);
}

/// Multiply-adds that wait for nothing: 16 sums side by side, each as wide as the widest register. One operation is a multiplication or an
/// addition of one Real.
void multiply_add(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(0)));
    using Wide = Real __attribute__((vector_size(64)));
    constexpr int sums = 16, rounds = 10000, lanes_of = 64 / sizeof(Real);
    const Index blocks = 64 * threads();
    std::vector<Real> results(static_cast<std::size_t>(blocks));
    for (auto _ : state) {
        parallel_tasks(blocks, [&](Index b) {
            Wide sum[sums] = {};
            const Wide a = Wide{} + Real(0.999), c = Wide{} + Real(1e-3) * static_cast<Real>(b);
            for (int k = 0; k < rounds; ++k)
                for (Wide& s : sum) s = s * a + c;
            Real all = 0;
            for (const Wide& s : sum) all += s[0];
            results[static_cast<std::size_t>(b)] = all;
        });
        benchmark::DoNotOptimize(results.data());
    }
    const double operations = 2.0 * sums * rounds * lanes_of * blocks;
    state.counters["Gop/s"] = benchmark::Counter(1e-9 * operations * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

}  // namespace

// Megabytes, threads; threads.
BENCHMARK(read_memory)->ArgsProduct({{1, 256}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(multiply_add)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

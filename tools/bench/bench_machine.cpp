/// Limits of the machine, as a reference for the other benchmarks: bytes per second from memory, operations per second in registers.
#include <benchmark/benchmark.h>

#include "engine/core/column.h"
#include "engine/core/parallel.h"

using namespace whorl;

namespace {

/// Sums a column of a given size [MB]. One of 1 MB stays in the cache of a core, one of 256 MB is read from memory.
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

/// Independent multiply-adds in 16 sums, each as wide as the widest register (64 bytes). One operation is a multiplication or an addition
/// of one Real.
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

// Arguments of read_memory: megabytes, threads; of multiply_add: threads.
BENCHMARK(read_memory)->ArgsProduct({{1, 256}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(multiply_add)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

int main(int argc, char** argv) {
    whorl::wait_passively(argv);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
}

#pragma once
/// Parallel loops and sums whose results do not depend on the number of threads.
#include <omp.h>

#include <algorithm>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// Sets the number of threads of all parallel loops, once, for OpenMP (and, through render/, for TBB). 0: all cores.
void set_threads(int count);
int threads();

/// Call first in every thread that OpenMP did not start, so that parallel loops of that thread use the chosen number of threads. OpenMP
/// keeps that number separately for each thread.
void adopt_threads();

/// Makes idle OpenMP threads sleep instead of spin, which would slow other programs on a shared machine. Call it first in main(): libgomp
/// reads its policy before main() starts, so this restarts the program once with a passive policy, unless the user has set one.
void wait_passively(char** argv);

/// A loop with fewer iterations runs on the calling thread: waking the others would cost more than it saves.
inline constexpr Index serial_below = 512;

/// Calls f(begin, end) for fixed blocks that cover [0, n). Each call must write only data of its block. The body is compiled once and
/// always runs over the same blocks: if it were inlined twice, for one thread and for several, the compiler might contract or vectorise
/// the two copies differently, and the results would not be bit-identical.
template <class F>
void parallel_blocks(Index n, Index block, F&& f) {
    const auto run = [&f](Index begin, Index end) __attribute__((noinline)) { f(begin, end); };
    const Index blocks = (n + block - 1) / block;
    if (n < serial_below || blocks < 2 || threads() == 1) {
        for (Index b = 0; b < blocks; ++b) run(b * block, std::min(n, (b + 1) * block));
        return;
    }
#pragma omp parallel for schedule(dynamic, 1)
    for (Index b = 0; b < blocks; ++b) run(b * block, std::min(n, (b + 1) * block));
}

/// Calls f(i) for i in [0, n). Each f(i) must write only data of i.
template <class F>
void parallel_for(Index n, F&& f) {
    parallel_blocks(n, 256, [&f](Index begin, Index end) {
        for (Index i = begin; i < end; ++i) f(i);
    });
}

/// parallel_for() for few long iterations. Each thread fetches one iteration at a time.
template <class F>
void parallel_tasks(Index n, F&& f) {
    const auto run = [&f](Index i) __attribute__((noinline)) { f(i); };
#pragma omp parallel for schedule(dynamic, 1) if (n > 1 && threads() > 1)
    for (Index i = 0; i < n; ++i) run(i);
}

/// sum_i f(i), in double, over fixed blocks that are added in order. The result is bit-identical for any number of threads.
/// @param zero the zero of T, which needs operator+=
template <class T, class F>
T parallel_sum(Index n, T zero, F&& f) {
    constexpr Index block = 1024;
    const Index blocks = (n + block - 1) / block;
    std::vector<T> partial(blocks, zero);
    parallel_blocks(n, block, [&](Index begin, Index end) {
        T sum = zero;
        for (Index i = begin; i < end; ++i) sum += f(i);
        partial[begin / block] = sum;
    });
    T total = zero;
    for (const T& p : partial) total += p;
    return total;
}

template <class F>
double parallel_sum(Index n, F&& f) {
    return parallel_sum(n, 0.0, [&](Index i) { return static_cast<double>(f(i)); });
}

/// max(lowest, max_i f(i)).
template <class F>
double parallel_max(Index n, double lowest, F&& f) {
    constexpr Index block = 1024;
    const Index blocks = (n + block - 1) / block;
    std::vector<double> partial(blocks, lowest);
    parallel_blocks(n, block, [&](Index begin, Index end) {
        double most = lowest;
        for (Index i = begin; i < end; ++i) most = std::max(most, static_cast<double>(f(i)));
        partial[begin / block] = most;
    });
    double most = lowest;
    for (double p : partial) most = std::max(most, p);
    return most;
}

}  // namespace whorl

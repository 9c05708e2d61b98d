#pragma once
/// Parallel loops whose results do not depend on the number of threads down to the last bit: the body is compiled once and always runs over the
/// same ranges. (Inlined twice, for one thread and for several, the compiler may contract or vectorise the two copies differently.)
#include "engine/core/parallel.h"

namespace whorl {

/// Calls f(i) for i in [0, n): for few iterations that each take long. Threads fetch them one by one.
template <class F>
void parallel_tasks(Index n, const F& f) {
    const auto one = [&f](Index i) __attribute__((noinline)) { f(i); };
#pragma omp parallel for schedule(dynamic, 1) if (n > 1 && threads() > 1)
    for (Index i = 0; i < n; ++i) one(i);
}

/// Calls f(i) for i in [0, n): for many short iterations.
template <class F>
void parallel_each(Index n, const F& f) {
    constexpr Index block = 256;
    const auto range = [&f](Index begin, Index end) __attribute__((noinline)) {
        for (Index i = begin; i < end; ++i) f(i);
    };
#pragma omp parallel for schedule(dynamic, 1) if (n >= serial_below && threads() > 1)
    for (Index b = 0; b < (n + block - 1) / block; ++b) range(b * block, std::min(n, (b + 1) * block));
}

}  // namespace whorl

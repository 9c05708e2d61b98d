#include "engine/core/parallel.h"

#include <unistd.h>

#include <cstdlib>

namespace whorl {
namespace {
int chosen = 0;
}

void set_threads(int count) {
    chosen = count > 0 ? count : omp_get_num_procs();
    omp_set_num_threads(chosen);
}

int threads() {
    if (chosen == 0) set_threads(0);
    return chosen;
}

void adopt_threads() { omp_set_num_threads(threads()); }

void wait_passively(char** argv) {
    if (std::getenv("OMP_WAIT_POLICY") != nullptr || std::getenv("GOMP_SPINCOUNT") != nullptr) return;
    setenv("OMP_WAIT_POLICY", "passive", 1);
    // 200 spins bridge the gap between two loops of a solve, if both threads have a core. Longer waiting wastes the time of other programs:
    // with other programs on both cores, two threads on 8192 particles need as much CPU time as one thread with 200 spins, 15 % more with
    // 500 and 40 % more with 1000, and the least wall time is the same (docs/reports/speed.md).
    setenv("GOMP_SPINCOUNT", "200", 1);
    char program[4096];  // the program's real path, because as /proc/self/exe its process name would be "exe"
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length <= 0) return;
    program[length] = 0;
    execv(program, argv);  // returns only on failure, and the program then continues without passive waiting
}

}  // namespace whorl

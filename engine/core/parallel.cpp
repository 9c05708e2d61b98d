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
    // Some tens of microseconds, the time to wake a thread. Between two loops of a solve that is enough: two threads on 16 000
    // particles take 2.6 us a particle-step rather than 3.8 and more, and two such runs on the same two cores no longer than without (with
    // 2000 a third longer, with 10 000 twice as long).
    setenv("GOMP_SPINCOUNT", "1000", 1);
    char program[4096];  // by its own path: named "exe" it would not be found by name among the processes
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length <= 0) return;
    program[length] = 0;
    execv(program, argv);  // returns only on failure: then the program continues
}

}  // namespace whorl

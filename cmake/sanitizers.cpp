// Compiled into every program of the presets asan and tsan: suppressions for third-party libraries that are not instrumented (never for
// this project's code), and an implementation of OpenMP loops by threads that ThreadSanitizer can follow.

extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions();

/// Mesa and LLVM keep compiled code until the process ends.
const char* __lsan_default_suppressions() {
    return "leak:libgallium\n"
           "leak:swrast_dri\n"
           "leak:libLLVM\n"
           "leak:libEGL\n"
           "leak:libGLdispatch\n";
}

/// Threads of Mesa and TBB synchronise inside libraries that are not instrumented.
const char* __tsan_default_suppressions() {
    return "called_from_lib:libgallium\n"
           "called_from_lib:swrast_dri.so\n"
           "called_from_lib:libEGL_mesa.so\n"
           "called_from_lib:libLLVM\n"
           "called_from_lib:libtbb.so\n"
           "called_from_lib:libopenvdb.so\n"
           "mutex:libGLdispatch.so\n"
           "mutex:whorl::write_vdb\n"  // OpenVDB's own lock, taken and released inside its initialize()
           "race:libgcc_s.so\n"        // its table of generated code, during an exception
           "mutex:libgcc_s.so\n"       // the lock of that table
           "deadlock:libgcc_s.so\n";
}

#ifdef __SANITIZE_THREAD__
#include <omp.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

// gcc's OpenMP library is not instrumented: ThreadSanitizer sees no order between its threads and would report every loop. The functions
// below replace the library's entry points for `omp parallel for schedule(dynamic)`, with threads that are started and joined for each
// loop. A race inside a loop's body is still detected.
namespace {

/// The threads of one parallel region, and the one loop that they share.
struct Team {
    std::once_flag started;
    std::atomic<long> next{0};
    long end = 0, stride = 1;

    bool fetch(long* first, long* last) {
        const long from = next.fetch_add(stride);
        if (from >= end) return false;
        *first = from;
        *last = std::min(end, from + stride);
        return true;
    }
};
thread_local Team* own_team = nullptr;

/// TBB is not instrumented either, so its algorithms, which OpenVDB uses, run on the calling thread.
const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);

}  // namespace

extern "C" {
void GOMP_parallel(void (*body)(void*), void* data, unsigned count, unsigned /*flags*/) {
    Team team;
    Team* const outer = own_team;
    const auto work = [&] {
        Team* const before = own_team;
        own_team = &team;
        body(data);
        own_team = before;
    };
    if (count == 0) count = static_cast<unsigned>(omp_get_max_threads());
    std::vector<std::thread> others;
    for (unsigned t = 1; t < count && outer == nullptr; ++t)
        others.emplace_back(work);  // as in OpenMP, a nested region runs on its calling thread only
    work();
    for (std::thread& other : others) other.join();
}
bool GOMP_loop_nonmonotonic_dynamic_start(long start, long end, long step, long chunk, long* first, long* last) {
    Team& team = *own_team;
    std::call_once(team.started, [&] {
        team.next = start;
        team.end = end;
        team.stride = step * chunk;
    });
    return team.fetch(first, last);
}
bool GOMP_loop_nonmonotonic_dynamic_next(long* first, long* last) { return own_team->fetch(first, last); }
void GOMP_loop_end_nowait() {}
}
#endif

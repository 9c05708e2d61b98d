#pragma once
/// Clocks, and wall and CPU seconds per stage.
#include <chrono>
#include <ctime>
#include <map>
#include <string>

namespace whorl {

inline double wall_seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// CPU seconds of the process, summed over its threads.
inline double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct StageTime {
    double wall = 0;  ///< s
    double cpu = 0;   ///< s
    long calls = 0;
};

using StageTimes = std::map<std::string, StageTime>;

}  // namespace whorl

#include "tools/process/usage.h"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "engine/core/clock.h"

namespace whorl {
namespace {

/// The rest of the line that starts with `key` in a file of "key: value" lines.
std::string value_after(const char* file, const std::string& key) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.compare(0, key.size(), key) == 0) {
            const std::size_t colon = line.find(':');
            const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
            return begin == std::string::npos ? "" : line.substr(begin);
        }
    return "";
}

}  // namespace

void name_thread(const char* name) { pthread_setname_np(pthread_self(), name); }

std::map<std::string, double> cpu_by_thread_name() {
    std::map<std::string, double> seconds;
    std::error_code gone;  // threads may end while we look
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", gone)) {
        std::string name;
        double nanoseconds = 0;
        std::getline(std::ifstream(task.path() / "comm"), name);
        std::ifstream(task.path() / "schedstat") >> nanoseconds;
        if (name.rfind("llvmpipe", 0) == 0) name = "draw";
        seconds[name] += 1e-9 * nanoseconds;
    }
    return seconds;
}

double children_cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double process_cpu_seconds() { return cpu_seconds() + children_cpu_seconds(); }

double simulation_cpu_seconds() {
    double sum = 0;
    for (const auto& [name, seconds] : cpu_by_thread_name())
        if (name != "surface" && name != "draw" && name != "export" && name != "write") sum += seconds;
    return sum;
}

std::uint64_t peak_memory() {
    std::istringstream in(value_after("/proc/self/status", "VmHWM"));
    std::uint64_t kilobytes = 0;
    in >> kilobytes;
    return 1024 * kilobytes;
}

std::uint64_t resident_memory() {
    std::istringstream in(value_after("/proc/self/status", "VmRSS"));
    std::uint64_t kilobytes = 0;
    in >> kilobytes;
    return 1024 * kilobytes;
}

std::string processor_name() { return value_after("/proc/cpuinfo", "model name"); }

std::uint64_t total_memory() {
    return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace whorl

#include "engine/scene/available_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

namespace whorl {
namespace {

namespace fs = std::filesystem;

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The first number in a file; infinite if there is none.
double number_in(const fs::path& file) {
    std::ifstream in(file);
    double number = 0;
    return in >> number ? number : unlimited;
}

/// The number after a name in a file of lines "name number"; 0 if the name does not occur.
double number_called(const std::string& name, const fs::path& file) {
    std::ifstream in(file);
    double number = 0;
    for (std::string word; in >> word;)
        if (word == name && in >> number) return number;
    return 0;
}

/// Names of the same files and entries in the two versions of control groups.
struct GroupFiles {
    const char *most, *used, *given_back;
};
constexpr GroupFiles version_1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"},
    version_2{"memory.max", "memory.current", "inactive_file"};

/// Memory that a group and its parents leave free. They count inactive cached files as used, but these can be freed.
double free_in_groups(const fs::path& mount, fs::path group, const GroupFiles& files) {
    double least = unlimited;
    for (group = group.relative_path();; group = group.parent_path()) {
        const fs::path folder = mount / group;
        const double most = number_in(folder / files.most), used = number_in(folder / files.used);
        if (most < unlimited && used < unlimited)
            least = std::min(least, most - used + number_called(files.given_back, folder / "memory.stat"));
        if (group.empty()) return least;
    }
}

/// Largest address space that this process may have; infinite without a limit.
double address_space(const fs::path& limits) {
    const std::string name = "Max address space";
    std::ifstream in(limits);
    for (std::string line; std::getline(in, line);)
        if (double most = 0; line.rfind(name, 0) == 0 && std::istringstream(line.substr(name.size())) >> most) return most;
    return unlimited;
}

}  // namespace

double available_memory(const fs::path& root) {
    double least = unlimited;
    if (const double kilobytes = number_called("MemAvailable:", root / "proc/meminfo"); kilobytes > 0) least = 1024 * kilobytes;
    // Lines are like "4:memory:/slurm/job_7" (version 1) and "0::/user.slice" (version 2). In a container the group's name may be that
    // outside it; its files are then in the root of the mount.
    std::ifstream groups(root / "proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string of = "," + line.substr(first + 1, second - first - 1) + ",", group = line.substr(second + 1);
        const fs::path mounts = root / "sys/fs/cgroup";
        if (of == ",,") {
            for (const char* mount : {"", "unified"}) least = std::min(least, free_in_groups(mounts / mount, group, version_2));
        } else if (of.find(",memory,") != std::string::npos) {
            least = std::min(least, free_in_groups(mounts / "memory", group, version_1));
        }
    }
    const double held = 1024 * number_called("RssAnon:", root / "proc/self/status");
    return std::min(std::max(least, 0.0) + held, address_space(root / "proc/self/limits"));
}

}  // namespace whorl

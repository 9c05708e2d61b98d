#include "engine/scene/available_memory.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "tests/support/scratch.h"

using namespace whorl;
namespace fs = std::filesystem;

namespace free_memory_test {

namespace {

/// A machine with 8 GB free.
struct Machine : test::ScratchFolder {
    explicit Machine(const std::string& groups) {
        write("proc/meminfo", "MemTotal:  16000000 kB\nMemAvailable:  8000000 kB\n");
        write("proc/self/cgroup", groups);
    }
    void write(const fs::path& file, const std::string& text) const {
        fs::create_directories((*this / file).parent_path());
        std::ofstream(*this / file) << text;
    }
    double available() const { return available_memory(path()); }
    /// Available memory after the file was written.
    double with(const fs::path& file, const std::string& text) const {
        write(file, text);
        return available();
    }
};

}  // namespace

TEST_CASE("free memory is the minimum over the machine and all enclosing control groups", "[scene]") {
    const Machine machine("0::/user.slice/job.scope\n");
    CHECK(machine.available() == 8.192e9);
    machine.write("sys/fs/cgroup/user.slice/job.scope/memory.max", "max\n");
    CHECK(machine.with("sys/fs/cgroup/user.slice/job.scope/memory.current", "500000000\n") == 8.192e9);
    machine.write("sys/fs/cgroup/user.slice/memory.max", "4000000000\n");
    CHECK(machine.with("sys/fs/cgroup/user.slice/memory.current", "1500000000\n") == 2.5e9);
    CHECK(machine.with("sys/fs/cgroup/user.slice/job.scope/memory.max", "3000000000\n") == 2.5e9);
    CHECK(machine.with("sys/fs/cgroup/user.slice/job.scope/memory.max", "2000000000\n") == 1.5e9);
    // Cached files count as free memory.
    CHECK(machine.with("sys/fs/cgroup/user.slice/job.scope/memory.stat", "anon 100\ninactive_file 300000000\n") == 1.8e9);
}

TEST_CASE("a container's group counts if its files are at the root", "[scene]") {
    const Machine machine("0::/docker/0a1b\n");
    machine.write("sys/fs/cgroup/memory.max", "1000000000\n");
    CHECK(machine.with("sys/fs/cgroup/memory.current", "250000000\n") == 7.5e8);
}

TEST_CASE("the memory controller of cgroup v1 counts", "[scene]") {
    const Machine machine("5:cpu,cpuacct:/\n4:hugetlb,memory:/slurm/uid_1/job_2\n0::/\n");
    const fs::path job = "sys/fs/cgroup/memory/slurm/uid_1/job_2";
    machine.write(job / "memory.limit_in_bytes", "9223372036854771712\n");
    CHECK(machine.with(job / "memory.usage_in_bytes", "700000000\n") == 8.192e9);
    CHECK(machine.with(job / "memory.limit_in_bytes", "3000000000\n") == 2.3e9);
}

TEST_CASE("memory that the process already uses counts as free, up to an address space limit", "[scene]") {
    const Machine machine("0::/job\n");
    CHECK(machine.with("proc/self/status", "VmRSS:\t  6000000 kB\nRssAnon:\t  5000000 kB\n") == 13.312e9);
    machine.write("sys/fs/cgroup/job/memory.max", "7000000000\n");
    CHECK(machine.with("sys/fs/cgroup/job/memory.current", "6000000000\n") == 6.12e9);
    CHECK(machine.with("proc/self/limits", "Max data size   1000   1000   bytes\nMax address space   unlimited   unlimited   bytes\n") ==
          6.12e9);
    CHECK(machine.with("proc/self/limits", "Max data size   1000   1000   bytes\nMax address space   3000000000   unlimited   bytes\n") ==
          3e9);
}

}  // namespace free_memory_test

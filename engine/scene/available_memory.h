#pragma once
/// Memory available to a run.
#include <filesystem>

namespace whorl {

/// Memory available to a run in this process [bytes]. It is the least of the machine's free memory, the free memory of each control group
/// (of a container, a job, their parents) and what the process's limit (ulimit -v) leaves. The memory that the process already uses is
/// added, because changes are planned during a run. Infinite without any limit.
/// @param root root of the system's files; a test passes those of another machine
double available_memory(const std::filesystem::path& root = "/");

}  // namespace whorl

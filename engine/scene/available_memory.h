#pragma once
/// Memory available to a run.
#include <filesystem>

namespace whorl {

/// Memory available to a run in this process [bytes]: the smallest of the machine's free memory, that of each control group (of a
/// container, a job, their parents) and the process's limit (ulimit -v), plus the memory that the process already uses, because changes
/// are planned during a run. Infinite without any limit.
/// @param root root of the system's files; a test passes those of another machine
double available_memory(const std::filesystem::path& root = "/");

}  // namespace whorl

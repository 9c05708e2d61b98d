#pragma once
/// How much memory there is for a run.
#include <filesystem>

namespace whorl {

/// Memory available to a run in this process [bytes]: the minimum of the machine's, each control group's (a container's, a job's, their
/// parents') and the process's limit (ulimit -v), plus the memory that it already holds, since changes are planned during a run.
/// Infinite without any limit.
/// @param root of the system's files: those of another machine, for a test
double available_memory(const std::filesystem::path& root = "/");

}  // namespace whorl

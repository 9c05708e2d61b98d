#pragma once
/// How much memory there still is for a run.
#include <filesystem>

namespace whorl {

/// What the system can still give [bytes]: the machine, each control group that this runs in (a container's, a job's, their parents'), and
/// the limit of the process (ulimit -v). Infinite where none of them says.
/// @param root of the system's files: those of another machine, for a test
double free_memory(const std::filesystem::path& root = "/");

}  // namespace whorl

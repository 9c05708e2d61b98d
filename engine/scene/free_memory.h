#pragma once
/// How much memory there is for a run.
#include <filesystem>

namespace whorl {

/// What a run in this process may take [bytes]: what the machine, each control group that this runs in (a container's, a job's, their
/// parents') and the limit of the process (ulimit -v) leave it, with what it holds already: a change is planned while its run is on.
/// Infinite where none of them says.
/// @param root of the system's files: those of another machine, for a test
double free_memory(const std::filesystem::path& root = "/");

}  // namespace whorl

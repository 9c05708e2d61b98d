#pragma once
/// How the program ends.
#include <functional>

namespace whorl {

enum ExitCode : int {
    exit_done = 0,
    exit_failed = 1,        ///< the run failed: diverged, disk full, no EGL device; what was made stays
    exit_bad_input = 2,     ///< the user's mistake; nothing was written
    exit_interrupted = 130  ///< SIGINT or SIGTERM; the state is saved
};

/// Runs the job; prints whatever it throws on standard error ("whorl: ..."), one line a problem, and returns the exit code.
int run_guarded(const std::function<int()>& job);

}  // namespace whorl

#pragma once
/// The process of the program: exit codes, interrupts, the path of its file, child programs, Slurm jobs, CPU time and memory.
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace whorl {

enum ExitCode : int {
    exit_done = 0,
    exit_failed = 1,        ///< the run failed: diverged, disk full, no EGL device; finished files are kept
    exit_bad_input = 2,     ///< invalid input; nothing was written
    exit_interrupted = 130  ///< SIGINT or SIGTERM; the state is saved
};

/// Exception: SIGINT or SIGTERM arrived before the first frame.
struct Interrupted {};

/// Runs the job and returns its exit code. If it throws, prints each problem of the input, or "whorl: ..." for
/// another exception, on standard error, and returns the exit code for that kind of failure.
int run_guarded(const std::function<int()>& job);

/// While an InterruptGuard exists, the first SIGINT or SIGTERM only sets a flag. The second one ends the program immediately.
class InterruptGuard {
public:
    InterruptGuard();
    ~InterruptGuard();
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;
    bool interrupted() const;
};

/// Path of this program (/proc/self/exe). @throws EnvironmentError without /proc
std::filesystem::path program_path();

/// Starts a program in a new process group, so that Ctrl-C in the terminal does not interrupt it.
/// @param words the program and its arguments
/// @param output file for its standard output and error; the program is then killed when this one ends. Empty: it inherits both.
/// @throws EnvironmentError
pid_t start_program(const std::vector<std::string>& words, const std::filesystem::path& output = {});

/// Number of the job that sbatch submitted; "" if the output contains none.
/// @param output of `sbatch --parsable`: a line with the number, on some clusters with a name ("7;north"), among notices of the cluster
std::string slurm_job(const std::string& output);

/// Whether one of the jobs ("7,8") is waiting or running. False without Slurm, or if Slurm no longer lists them.
bool slurm_jobs_live(const std::string& jobs);

/// Copy of a value that the mutex protects.
template <class T>
T locked(std::mutex& mutex, const T& value) {
    const std::lock_guard lock(mutex);
    return value;
}

/// Names the calling thread. Threads that it starts afterwards (OpenMP's, TBB's) inherit the name, so their CPU time is counted under it.
void name_thread(const char* name);
/// CPU seconds of the running threads, by thread name. Threads of Mesa ("llvmpipe-0", ...) count as "draw".
std::map<std::string, double> cpu_by_thread_name();
/// CPU seconds of the child processes that have ended (the encoder).
double children_cpu_seconds();
/// CPU seconds of the program and its ended child processes.
double process_cpu_seconds();
/// CPU seconds of the running threads except those of images and files ("surface", "draw", "export", "write").
double simulation_cpu_seconds();
/// Peak resident memory of the process [bytes].
std::uint64_t peak_memory();
/// Current resident memory of the process [bytes].
std::uint64_t resident_memory();
/// Model of the processor, "AMD EPYC ..."; "" if unknown.
std::string processor_name();
/// Memory of the machine [bytes].
std::uint64_t total_memory();

}  // namespace whorl

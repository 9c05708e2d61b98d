#pragma once
/// The program as a process: how it ends, interrupts, its own file, jobs of Slurm, its use of the machine.
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace whorl {

enum ExitCode : int {
    exit_done = 0,
    exit_failed = 1,        ///< the run failed: diverged, disk full, no EGL device; finished files are kept
    exit_bad_input = 2,     ///< the user's mistake; nothing was written
    exit_interrupted = 130  ///< SIGINT or SIGTERM; the state is saved
};

/// SIGINT or SIGTERM came before anything was made.
struct Interrupted {};

/// Runs the job; prints whatever it throws on standard error ("whorl: ..."), one line a problem, and returns the exit code.
int run_guarded(const std::function<int()>& job);

/// While one lives, the first SIGINT or SIGTERM only sets a flag; the second ends the program at once.
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

/// Starts a program in a new process group, which the terminal's interrupt does not reach.
/// @param output file for what it writes, and it is killed when this program ends; empty: it writes where this program writes
/// @throws EnvironmentError
pid_t start_program(const std::vector<std::string>& words, const std::filesystem::path& output = {});

/// The number of the job that sbatch made. @param said output of `sbatch --parsable`: the number, in some places with the cluster's name
/// ("7;north"), among notices of the place's own @return "" where it made none
std::string slurm_job(const std::string& said);

/// Whether one of the jobs ("7,8") waits or runs. False without Slurm, or if it has forgotten them.
bool slurm_jobs_live(const std::string& jobs);

/// Gives the calling thread a name. Threads that it starts from then on (OpenMP's, TBB's) inherit it, so that their CPU time counts with
/// it.
void name_thread(const char* name);
/// CPU seconds used by the living threads, by thread name. Mesa's own ("llvmpipe-0", ...) count as "draw".
std::map<std::string, double> cpu_by_thread_name();
/// CPU seconds of the child processes that have ended (the encoder).
double children_cpu_seconds();
/// CPU seconds used by the program with its encoders; and by its threads except those that make images ("surface", "draw",
/// "export", "write").
double process_cpu_seconds();
double simulation_cpu_seconds();
/// The process's peak resident memory [bytes].
std::uint64_t peak_memory();
/// The process's resident memory now [bytes].
std::uint64_t resident_memory();
/// "AMD EPYC ...", and the machine's memory [bytes].
std::string processor_name();
std::uint64_t total_memory();

}  // namespace whorl

#include "tools/process/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <new>
#include <sstream>
#include <system_error>

#include "engine/core/clock.h"
#include "engine/core/errors.h"
#include "render/video/process.h"

namespace whorl {

int run_guarded(const std::function<int()>& job) {
    try {
        return job();
    } catch (const InputError& e) {
        for (const Problem& p : e.problems()) fmt::print(stderr, "{}\n", p.message());
        return exit_bad_input;
    } catch (const Interrupted&) {
        fmt::print(stderr, "whorl: interrupted before the first frame\n");
        return exit_interrupted;
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "whorl: memory ran out\n  remedy: free memory, allow more (ulimit -v), or use a larger fluid.spacing\n");
        return exit_failed;
    } catch (const std::system_error& e) {
        const bool thread = e.code() == std::errc::resource_unavailable_try_again;
        if (thread)
            fmt::print(stderr, "whorl: cannot start a thread: {}\n  remedy: allow more memory (ulimit -v) or threads (ulimit -u)\n",
                       e.what());
        else fmt::print(stderr, "whorl: {}\n", e.what());
        return exit_failed;
    } catch (const std::exception& e) {  // usually an EnvironmentError
        fmt::print(stderr, "whorl: {}\n", e.what());
        return exit_failed;
    }
}

namespace {

/// Set by the signal handler, which may run in any thread.
std::atomic<bool> received = false;
std::atomic<int> guards = 0;
static_assert(std::atomic<bool>::is_always_lock_free);

void note(int) {
    if (received.exchange(true)) _exit(130);
}

void handle(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
    if (guards++ > 0) return;
    received = false;
    handle(note);
}
InterruptGuard::~InterruptGuard() {
    if (--guards == 0) handle(SIG_DFL);
}
bool InterruptGuard::interrupted() const { return received; }

namespace fs = std::filesystem;

pid_t start_program(const std::vector<std::string>& words, const std::filesystem::path& output) {
    std::vector<char*> argv;
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    const int file = output.empty() ? -1 : open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    const pid_t pid = fork();
    if (pid < 0) throw EnvironmentError("cannot start " + words[0]);
    if (pid == 0) {
        setpgid(0, 0);
        if (!output.empty()) prctl(PR_SET_PDEATHSIG, SIGKILL), dup2(file, STDOUT_FILENO), dup2(file, STDERR_FILENO);
        execvp(argv[0], argv.data());
        _exit(127);
    }
    if (file >= 0) close(file);
    return pid;
}

fs::path program_path() {
    std::error_code error;
    const fs::path file = fs::read_symlink("/proc/self/exe", error);
    if (error) throw EnvironmentError("cannot find this program's file: /proc/self/exe cannot be read", error.message(), "mount /proc");
    return file;
}

std::string slurm_job(const std::string& output) {
    std::istringstream in(output);
    for (std::string line; std::getline(in, line);) {
        const std::string number = line.substr(0, line.find(';'));
        if (!number.empty() && number.find_first_not_of("0123456789") == std::string::npos) return number;
    }
    return {};
}

bool slurm_jobs_live(const std::string& jobs) try {
    ChildProcess squeue({"squeue", "--noheader", "--jobs=" + jobs, "--format=%i"});
    return squeue.wait() == 0 && squeue.output().find_first_not_of('\n') != std::string::npos;
} catch (const std::system_error&) { return false; }

namespace {

/// The rest of the line that starts with `key` in a file of "key: value" lines.
std::string value_after(const char* file, const std::string& key) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.compare(0, key.size(), key) == 0) {
            const std::size_t colon = line.find(':');
            const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
            return begin == std::string::npos ? "" : line.substr(begin);
        }
    return "";
}

}  // namespace

void name_thread(const char* name) { pthread_setname_np(pthread_self(), name); }

std::map<std::string, double> cpu_by_thread_name() {
    std::map<std::string, double> seconds;
    std::error_code ended;  // a thread may end during the iteration
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", ended)) {
        std::string name;
        double nanoseconds = 0;
        std::getline(std::ifstream(task.path() / "comm"), name);
        std::ifstream(task.path() / "schedstat") >> nanoseconds;
        if (name.rfind("llvmpipe", 0) == 0) name = "draw";
        seconds[name] += 1e-9 * nanoseconds;
    }
    return seconds;
}

double children_cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double process_cpu_seconds() { return cpu_seconds() + children_cpu_seconds(); }

double simulation_cpu_seconds() {
    double sum = 0;
    for (const auto& [name, seconds] : cpu_by_thread_name())
        if (name != "surface" && name != "draw" && name != "export" && name != "write") sum += seconds;
    return sum;
}

std::uint64_t peak_memory() { return 1024 * std::strtoull(value_after("/proc/self/status", "VmHWM").c_str(), nullptr, 10); }

std::uint64_t resident_memory() { return 1024 * std::strtoull(value_after("/proc/self/status", "VmRSS").c_str(), nullptr, 10); }

std::string processor_name() { return value_after("/proc/cpuinfo", "model name"); }

std::uint64_t total_memory() {
    return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace whorl

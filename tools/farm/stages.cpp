#include "tools/farm/stages.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <thread>

#include "engine/core/errors.h"
#include "engine/core/whole_file.h"
#include "render/video/process.h"
#include "tools/process/slurm_job.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

std::string quoted(const std::string& word) {
    std::string text = "'";
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
}
std::string quoted(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + quoted(word);
    return text;
}

fs::path file_of(const fs::path& folder, const FarmStage& stage, std::size_t task, const char* what) {
    return folder / fmt::format("{}.{}.{}", stage.name, task, what);
}

/// A task that was begun and cannot go on (2: there is no checkpoint yet) is begun anew.
std::string script_of(const FarmStage& stage, const fs::path& folder, int threads) {
    std::string text = "#!/bin/bash\n# Runs one task of this stage: bash " + stage.name + ".sh NUMBER\n";
    text += "task=${1:-$SLURM_ARRAY_TASK_ID}\nexport OMP_NUM_THREADS=" + std::to_string(threads) + "\n";
    text += "files=" + quoted((folder / stage.name).string()) + ".$task\nrm -f \"$files.code\"\nrun() {\n  case $task in\n";
    for (std::size_t k = 0; k < stage.tasks.size(); ++k) {
        const FarmTask& task = stage.tasks[k];
        const std::string begin = quoted(task.command);
        text += fmt::format("  {}) ", k);
        if (task.begun.empty()) text += begin;
        else
            text += fmt::format("if [ -e {} ]; then {}; code=$?; [ $code -ne 2 ] && return $code; fi; {}", quoted(task.begun.string()),
                                quoted(task.go_on), begin);
        text += " ;;\n";
    }
    text += "  esac\n}\nrun >\"$files.log\" 2>&1 </dev/null\ncode=$?\n";
    return text + "echo $code >\"$files.code.part\" && mv \"$files.code.part\" \"$files.code\"\nexit $code\n";
}

std::optional<int> code_of(const fs::path& folder, const FarmStage& stage, std::size_t task) {
    std::ifstream in(file_of(folder, stage, task, "code"));
    int code = 0;
    return in >> code ? std::optional(code) : std::nullopt;
}

std::string last_lines(const fs::path& file) {
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    std::string all = text.str();
    while (!all.empty() && all.back() == '\n') all.pop_back();
    return all.size() <= 500 ? all : "..." + all.substr(all.size() - 500);
}

/// @throws EnvironmentError with the first task of the stage that did not end well
void check_codes(const fs::path& folder, const FarmStage& stage) {
    for (std::size_t k = 0; k < stage.tasks.size(); ++k) {
        const auto code = code_of(folder, stage, k);
        if (code == 0) continue;
        const fs::path log = file_of(folder, stage, k, "log");
        throw EnvironmentError(fmt::format("{}, {}: {}", stage.name, stage.tasks[k].name,
                                           code ? fmt::format("ended with {}: {}", *code, last_lines(log))
                                                : "was ended from outside (out of time or memory?)"),
                               "", "everything that it said is in " + log.string());
    }
}

/// One line: how many tasks of each stage have ended.
class FarmProgress {
public:
    FarmProgress(const std::vector<FarmStage>& stages, const fs::path& folder, bool quiet)
        : stages_(stages), folder_(folder), quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}
    ~FarmProgress() {
        if (open_) std::fputs("\n", stderr);
    }
    void show() {
        std::string line;
        for (const FarmStage& stage : stages_) {
            std::size_t ended = 0;
            for (std::size_t k = 0; k < stage.tasks.size(); ++k) ended += code_of(folder_, stage, k).has_value();
            line += fmt::format("{}{} {} of {}", line.empty() ? "" : ", ", stage.name, ended, stage.tasks.size());
        }
        if (quiet_ || line == shown_) return;
        shown_ = line, open_ = terminal_;
        std::fputs(((terminal_ ? "\r\033[K" : "") + line + (terminal_ ? "" : "\n")).c_str(), stderr);
        std::fflush(stderr);
    }

private:
    const std::vector<FarmStage>& stages_;
    const fs::path& folder_;
    bool quiet_, terminal_, open_ = false;
    std::string shown_;
};

/// A child that the interrupt of the terminal does not reach: it is ended as this program says.
pid_t start(const std::vector<std::string>& words) {
    std::vector<char*> argv;
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    const pid_t pid = fork();
    if (pid < 0) throw EnvironmentError("a task could not be started");
    if (pid == 0) {
        setpgid(0, 0);
        execvp(argv[0], argv.data());
        _exit(127);
    }
    return pid;
}

/// @return false: interrupted
bool run_here(const FarmStage& stage, const fs::path& folder, std::size_t jobs, const InterruptGuard& interrupt, FarmProgress& progress) {
    std::vector<pid_t> running;
    for (std::size_t next = 0; next < stage.tasks.size() || !running.empty();) {
        while (next < stage.tasks.size() && running.size() < jobs && !interrupt.interrupted())
            running.push_back(start({"bash", (folder / (stage.name + ".sh")).string(), std::to_string(next++)}));
        std::erase_if(running, [](pid_t pid) { return waitpid(pid, nullptr, WNOHANG) == pid; });
        progress.show();
        if (interrupt.interrupted()) {
            for (const pid_t pid : running) kill(-pid, SIGINT);  // a film saves its state
            for (const pid_t pid : running) waitpid(pid, nullptr, 0);
            return false;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
}

/// What a program of Slurm's prints. @throws EnvironmentError with what it said
std::string said_by(const std::vector<std::string>& words) {
    try {
        ChildProcess child(words);
        const int code = child.wait();
        std::string text = child.output();
        while (!text.empty() && text.back() == '\n') text.pop_back();
        if (code != 0) throw EnvironmentError(words[0] + " failed: " + text, "", "is Slurm up? sinfo tells");
        return text;
    } catch (const std::system_error& error) {
        throw EnvironmentError("cannot start " + words[0], error.what(), "go where Slurm's programs are, or farm with --on local");
    }
}

/// The whole array is submitted at once and begins when the stage before it has ended well. @return the job's number
std::string submit(const FarmStage& stage, const fs::path& folder, const FarmOptions& options, const std::string& after) {
    std::vector<std::string> words{
        "sbatch",
        "--parsable",
        "--requeue",
        "--job-name=whorl-" + stage.name,
        fmt::format("--array=0-{}{}", stage.tasks.size() - 1, options.jobs > 0 ? fmt::format("%{}", options.jobs) : ""),
        fmt::format("--cpus-per-task={}", options.threads),
        "--open-mode=append",
        "--output=" + (folder / (stage.name + ".%a.slurm")).string()};
    if (stage.seconds > 0) words.push_back(fmt::format("--time={:.0f}", std::ceil(stage.seconds / 60)));
    if (stage.bytes > 0) words.push_back(fmt::format("--mem={:.0f}M", std::ceil(stage.bytes / 1048576)));
    if (!after.empty()) words.push_back("--dependency=afterok:" + after), words.emplace_back("--kill-on-invalid-dep=yes");
    words.insert(words.end(), options.sbatch.begin(), options.sbatch.end());
    words.push_back((folder / (stage.name + ".sh")).string());
    const std::string said = said_by(words), job = slurm_job(said);
    if (job.empty()) throw EnvironmentError("sbatch names no job: " + said, "", "is Slurm up? sinfo tells");
    return job;
}

bool run_on_slurm(const std::vector<FarmStage>& stages, const fs::path& folder, const FarmOptions& options, const InterruptGuard& interrupt,
                  FarmProgress& progress) {
    std::string jobs, last;
    for (const FarmStage& stage : stages) jobs += (jobs.empty() ? "" : ",") + (last = submit(stage, folder, options, last));
    write_text(folder / "jobs.txt", jobs + "\n");
    const auto all_ended = [&] {
        for (const FarmStage& stage : stages)
            for (std::size_t k = 0; k < stage.tasks.size(); ++k)
                if (!code_of(folder, stage, k)) return false;
        return true;
    };
    for (int polls = 0, gone = 0; !all_ended() && gone < 3; ++polls) {
        progress.show();
        if (interrupt.interrupted()) {
            fmt::print(stderr, "\nwhorl: the jobs {0} go on; scancel {0} ends them\n", jobs);
            return false;
        }
        // Files may come later than the end of their job; Slurm is asked seldom.
        if (polls % 10 == 9) try {
                gone = said_by({"squeue", "--noheader", "--jobs=" + jobs, "--format=%i"}).empty() ? gone + 1 : 0;
            } catch (const EnvironmentError&) { ++gone; }  // it does not know the jobs any more, or cannot be asked just now
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    progress.show();
    return true;
}

}  // namespace

void check_farm(const FarmOptions& options) {
    if (options.on != "local" && options.on != "slurm") {
        const std::string near = nearest_name(options.on, {"local", "slurm"});
        throw InputError({"--on " + options.on, 0, 0}, "there is no such place", near.empty() ? "" : "did you mean \"" + near + "\"?",
                         "allowed: local or slurm");
    }
    if (options.on == "local" && !options.sbatch.empty())
        throw InputError({"--sbatch", 0, 0}, "means nothing on this machine, where no sbatch is asked", "add --on slurm, or leave it out");
    if (options.on == "slurm") said_by({"sbatch", "--version"});
}

void share_cores(FarmOptions& o, std::size_t tasks) {
    if (o.on == "slurm") {
        o.threads = std::max(1, o.threads);
        return;
    }
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    if (o.jobs == 0) o.jobs = std::min(static_cast<int>(std::max<std::size_t>(1, tasks)), std::max(1, cores / std::max(1, o.threads)));
    if (o.threads == 0) o.threads = std::max(1, cores / o.jobs);
}

bool run_stages(const std::vector<FarmStage>& stages, const fs::path& folder, const FarmOptions& options, const InterruptGuard& interrupt) {
    const fs::path here = fs::absolute(folder);
    fs::create_directories(here);
    for (const FarmStage& stage : stages) {
        write_text(here / (stage.name + ".sh"), script_of(stage, here, options.threads));
        for (std::size_t k = 0; k < stage.tasks.size(); ++k) fs::remove(file_of(here, stage, k, "code"));
    }
    FarmProgress progress(stages, here, options.quiet);
    progress.show();
    if (options.on == "slurm") {
        if (!run_on_slurm(stages, here, options, interrupt, progress)) return false;
        for (const FarmStage& stage : stages) check_codes(here, stage);
        return true;
    }
    for (const FarmStage& stage : stages) {
        if (!run_here(stage, here, static_cast<std::size_t>(std::max(1, options.jobs)), interrupt, progress)) return false;
        progress.show();
        check_codes(here, stage);
    }
    return true;
}

}  // namespace whorl

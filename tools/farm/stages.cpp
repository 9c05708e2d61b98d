#include "tools/farm/stages.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>
#include <thread>

#include "engine/core/errors.h"
#include "engine/core/whole_file.h"
#include "render/video/process.h"
#include "tools/film/progress.h"
#include "tools/process/process.h"

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

/// What stands in the file of a task's exit status where it was not begun.
constexpr int left_out = -1;

/// Commands that end the script where a task before this one did not end well. Files of other machines may come late.
std::string needs_of(const std::vector<FarmStage>& stages, std::size_t stage, const FarmTask& task, const fs::path& folder) {
    std::string text;
    for (std::size_t s = 0; s < stage; ++s)
        for (std::size_t k = 0; k < stages[s].tasks.size(); ++k) {
            const FarmTask& needed = stages[s].tasks[k];
            if (needed.film != task.film) continue;
            const bool diverged = task.takes_diverged && !needed.run.empty();
            text += fmt::format("need {}{}; ", quoted(file_of(folder, stages[s], k, "code").string()),
                                diverged ? " " + quoted((needed.run / "run.json").string()) : "");
        }
    return text;
}

/// A task that was begun, but not as far as a checkpoint, is begun anew.
std::string script_of(const std::vector<FarmStage>& stages, std::size_t number, const fs::path& folder, int threads) {
    const FarmStage& stage = stages[number];
    std::string text = "#!/bin/bash\n# Runs one task of this stage: bash " + stage.name + ".sh NUMBER\n";
    // The folder is kept from others while tasks wait (RunFolder).
    text += "task=${1:-$SLURM_ARRAY_TASK_ID}\nexport WHORL_FARM_TASK=1 OMP_NUM_THREADS=" + std::to_string(threads) + "\n";
    text += fmt::format("seq 0 {0} | grep -qx -- \"$task\" || {{ echo \"there is no task $task: 0 to {0}\" >&2; exit 2; }}\n",
                        stage.tasks.size() - 1);
    text += "files=" + quoted((folder / stage.name).string()) + ".$task\nrm -f \"$files.code\"\n";
    text += "end() { echo $1 >\"$files.code.part\" && mv \"$files.code.part\" \"$files.code\"; }\n";
    // Whoever runs a task by hand knows that it can be begun.
    text += "need() {\n  for try in ${SLURM_ARRAY_TASK_ID:+$(seq 30)}; do [ -e \"$1\" ] && break; sleep 1; done\n";
    text += "  [ \"$(cat \"$1\" 2>/dev/null)\" = 0 ] && return\n";
    text += "  [ -n \"$2\" ] && grep -q '\"status\": \"diverged\"' \"$2\" 2>/dev/null && return\n";
    text += fmt::format("  echo \"not begun: see $1\" >\"$files.log\"; end {}; exit 0\n}}\n", left_out);
    text += "run() {\n  case $task in\n";
    for (std::size_t k = 0; k < stage.tasks.size(); ++k) {
        const FarmTask& task = stage.tasks[k];
        const std::string begin = quoted(task.command);
        text += fmt::format("  {}) ", k);
        if (task.run.empty()) text += begin;
        else
            text += fmt::format("if [ -n \"$(ls {} 2>/dev/null)\" ]; then {}; else {}; fi", quoted((task.run / "checkpoints").string()),
                                quoted(task.go_on), begin);
        text += " ;;\n";
    }
    text += "  esac\n}\n[ -n \"$2$SLURM_ARRAY_TASK_ID\" ] && case $task in\n";
    for (std::size_t k = 0; k < stage.tasks.size(); ++k)
        if (const std::string needs = needs_of(stages, number, stage.tasks[k], folder); !needs.empty())
            text += fmt::format("  {}) {};;\n", k, needs);
    return text + "esac\nrun >\"$files.log\" 2>&1 </dev/null\ncode=$?\nend $code\nexit $code\n";
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

/// The tasks that failed. Those that were left out have their reason among them.
/// @param interrupted what has not ended was interrupted; a film of which something failed does not continue
FarmEnd end_of(const std::vector<FarmStage>& stages, const fs::path& folder, bool interrupted) {
    FarmEnd end{interrupted, {}, {}};
    for (const FarmStage& stage : stages)
        for (std::size_t k = 0; k < stage.tasks.size(); ++k) {
            const FarmTask& task = stage.tasks[k];
            const auto code = code_of(folder, stage, k);
            if (code == exit_done || code == left_out) continue;
            if (interrupted && code.value_or(exit_interrupted) == exit_interrupted) {
                const auto is_its = [&](const FarmFailure& failure) { return failure.film == task.film; };
                if (task.takes_diverged || std::none_of(end.failures.begin(), end.failures.end(), is_its))
                    end.stopped.try_emplace(task.film, stage.name);
                continue;
            }
            const fs::path log = file_of(folder, stage, k, "log");
            const std::string how =
                code ? fmt::format("ended with {}: {}", *code, last_lines(log)) : "was ended from outside (out of time or memory?)";
            end.failures.push_back({task.film, fmt::format("{}, {}: {}; the full log: {}", stage.name, task.name, how, log.string())});
        }
    return end;
}

/// One line: how many tasks of each stage have ended. Those that were left out are not among them.
class FarmProgress {
public:
    FarmProgress(const std::vector<FarmStage>& stages, const fs::path& folder, bool quiet)
        : stages_(stages), folder_(folder), line_(quiet) {}
    void show() {
        std::string line;
        for (const FarmStage& stage : stages_) {
            std::size_t ended = 0;
            for (std::size_t k = 0; k < stage.tasks.size(); ++k) ended += code_of(folder_, stage, k).value_or(left_out) != left_out;
            line += fmt::format("{}{} {} of {}", line.empty() ? "" : ", ", stage.name, ended, stage.tasks.size());
        }
        if (line != shown_) line_.show(shown_ = line);
    }

private:
    const std::vector<FarmStage>& stages_;
    const fs::path& folder_;
    StatusLine line_;
    std::string shown_;
};

/// @return false: interrupted
bool run_here(const FarmStage& stage, const fs::path& folder, std::size_t jobs, const InterruptGuard& interrupt, FarmProgress& progress) {
    std::vector<pid_t> running;
    for (std::size_t next = 0; next < stage.tasks.size() || !running.empty();) {
        while (next < stage.tasks.size() && running.size() < jobs && !interrupt.interrupted())
            running.push_back(start_program({"bash", (folder / (stage.name + ".sh")).string(), std::to_string(next++), "farm"}));
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

/// The whole array is submitted at once and begins when the stage before it has ended; tasks that this leaves without what they need end.
/// @return the job's number
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
    if (!after.empty()) words.push_back("--dependency=afterany:" + after);
    words.insert(words.end(), options.sbatch.begin(), options.sbatch.end());
    words.push_back((folder / (stage.name + ".sh")).string());
    const std::string said = said_by(words), job = slurm_job(said);
    if (job.empty()) throw EnvironmentError("sbatch names no job: " + said, "", "is Slurm up? sinfo tells");
    return job;
}

/// Says which jobs make these films: in the farm's own folder, and in those of the films.
void record_jobs(const std::vector<FarmStage>& stages, const fs::path& folder, const std::string& jobs) {
    std::set<fs::path> folders{folder};
    for (const FarmStage& stage : stages)
        for (const FarmTask& task : stage.tasks)
            if (!task.film.empty()) folders.insert(task.film / "farm");
    for (const fs::path& each : folders) write_text(each / "jobs.txt", jobs + "\n");
}

/// @return false: interrupted
bool run_on_slurm(const std::vector<FarmStage>& stages, const fs::path& folder, const FarmOptions& options, const InterruptGuard& interrupt,
                  FarmProgress& progress) {
    std::string jobs, last;
    for (const FarmStage& stage : stages) {
        jobs += (jobs.empty() ? "" : ",") + (last = submit(stage, folder, options, last));
        record_jobs(stages, folder, jobs);
    }
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
        if (polls % 10 == 9) gone = slurm_jobs_live(jobs) ? 0 : gone + 1;  // it may be that it cannot be asked just now
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

FarmEnd run_stages(const std::vector<FarmStage>& stages, const fs::path& folder, const FarmOptions& options,
                   const InterruptGuard& interrupt) {
    const fs::path here = fs::absolute(folder);
    fs::create_directories(here);
    for (std::size_t number = 0; number < stages.size(); ++number) {
        const FarmStage& stage = stages[number];
        write_text(here / (stage.name + ".sh"), script_of(stages, number, here, options.threads));
        for (std::size_t k = 0; k < stage.tasks.size(); ++k) fs::remove(file_of(here, stage, k, "code"));
    }
    FarmProgress progress(stages, here, options.quiet);
    progress.show();
    if (options.on == "slurm") {
        if (!run_on_slurm(stages, here, options, interrupt, progress)) return {true, {}, {}};
        return end_of(stages, here, false);
    }
    for (const FarmStage& stage : stages) {
        if (!run_here(stage, here, static_cast<std::size_t>(std::max(1, options.jobs)), interrupt, progress))
            return end_of(stages, here, true);
        progress.show();
    }
    return end_of(stages, here, false);
}

}  // namespace whorl

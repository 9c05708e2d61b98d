#include "tools/farm/stages.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <system_error>
#include <thread>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/io/csv.h"
#include "render/video/process.h"
#include "tools/film/progress.h"

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

fs::path script_of(const FarmFilm& film, const FarmStage& stage) { return film.folder / "farm" / (stage.name + ".sh"); }
fs::path file_of(const FarmFilm& film, const FarmStage& stage, std::size_t task, const char* what) {
    return film.folder / "farm" / fmt::format("{}.{}.{}", stage.name, task, what);
}

/// Writes the script that runs a task of the stage. A task whose run has no checkpoint starts from the beginning.
void write_script(const FarmFilm& film, const FarmStage& stage, int threads) {
    std::string text = "#!/bin/bash\n# Runs one task of this stage: bash " + stage.name + ".sh NUMBER\n";
    // WHORL_FARM_TASK lets tasks use the run folder while the farm has locked the subfolder farm (RunFolder).
    text += fmt::format("task=${{1:-$SLURM_ARRAY_TASK_ID}}\nexport WHORL_FARM_TASK=1 OMP_NUM_THREADS={}\ncase $task in\n", threads);
    for (std::size_t k = 0; k < stage.tasks.size(); ++k) {
        const FarmTask& task = stage.tasks[k];
        text += fmt::format("{}) run() {{ ", k);
        if (!task.run.empty())
            text += fmt::format("[ -n \"$(ls {} 2>/dev/null)\" ] && {{ {}; return; }}; ", quoted((task.run / "checkpoints").string()),
                                quoted(task.resume));
        text += quoted(task.command) + "; };;\n";
    }
    text += fmt::format("*) echo \"unknown task $task: 0 to {}\" >&2; exit 2;;\nesac\nfiles={}.$task\n", stage.tasks.size() - 1,
                        quoted((film.folder / "farm" / stage.name).string()));
    text += "rm -f \"$files.code\"\nrun >\"$files.log\" 2>&1 </dev/null\ncode=$?\n";
    write_text(script_of(film, stage), text + "echo $code >\"$files.part\" && mv \"$files.part\" \"$files.code\"\nexit $code\n");
}

/// Exit status of a task; nothing if it has not ended.
std::optional<int> code_of(const FarmFilm& film, const FarmStage& stage, std::size_t task) {
    std::ifstream in(file_of(film, stage, task, "code"));
    int code = 0;
    return in >> code ? std::optional(code) : std::nullopt;
}

/// Number of tasks of the stage that have ended, or only of those that succeeded.
std::size_t ended(const FarmFilm& film, const FarmStage& stage, bool succeeded = false) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < stage.tasks.size(); ++k)
        if (const auto code = code_of(film, stage, k)) count += !succeeded || *code == exit_done;
    return count;
}

/// Whether the results of the previous stage allow the stage to begin.
bool may_begin(const FarmFilm& film, std::size_t stage) {
    return stage == 0 || film.stages[stage].after_failures ||
           ended(film, film.stages[stage - 1], true) == film.stages[stage - 1].tasks.size();
}

bool has_ended(const FarmFilm& film) {
    for (std::size_t s = 0; s < film.stages.size() && may_begin(film, s); ++s)
        if (ended(film, film.stages[s]) < film.stages[s].tasks.size()) return false;
    return true;
}

FarmEnd end_of(const FarmFilm& film, bool interrupted) {
    FarmEnd end;
    for (std::size_t s = 0; s < film.stages.size() && may_begin(film, s); ++s)
        for (std::size_t k = 0; k < film.stages[s].tasks.size(); ++k) {
            const FarmStage& stage = film.stages[s];
            const auto code = code_of(film, stage, k);
            if (code == exit_done) continue;
            if (interrupted && code.value_or(exit_interrupted) == exit_interrupted) {
                end.stopped = stage.name;
                return end;
            }
            const fs::path log = file_of(film, stage, k, "log");
            const std::string how =
                code ? fmt::format("ended with {}: {}", *code, last_lines(read_whole(log))) : "was killed (out of time or memory?)";
            end.failures.push_back(fmt::format("{}, {}: {}; the full log: {}", stage.name, stage.tasks[k].name, how, log.string()));
        }
    return end;
}

/// Status line: how many tasks of each stage have ended, over all films.
class FarmProgress {
public:
    FarmProgress(const std::vector<FarmFilm>& films, bool quiet) : films_(films), line_(quiet) {}
    void show() {
        std::vector<std::pair<std::string, std::pair<std::size_t, std::size_t>>> counts;  ///< name, tasks that ended, all tasks
        for (const FarmFilm& film : films_)
            for (const FarmStage& stage : film.stages) {
                auto at = std::find_if(counts.begin(), counts.end(), [&](const auto& count) { return count.first == stage.name; });
                if (at == counts.end()) at = counts.insert(at, {stage.name, {0, 0}});
                at->second.first += ended(film, stage), at->second.second += stage.tasks.size();
            }
        std::string line;
        for (const auto& [name, count] : counts)
            line += fmt::format("{}{} {} of {}", line.empty() ? "" : ", ", name, count.first, count.second);
        if (line != shown_) line_.show(shown_ = line);
    }

private:
    const std::vector<FarmFilm>& films_;
    StatusLine line_;
    std::string shown_;
};

/// Runs the film's tasks on this machine, in sequence. @return false if interrupted
bool run_here(const FarmFilm& film, const InterruptGuard& interrupt, FarmProgress& progress) {
    for (std::size_t s = 0; s < film.stages.size() && may_begin(film, s); ++s)
        for (std::size_t k = 0; k < film.stages[s].tasks.size(); ++k) {
            if (interrupt.interrupted()) return false;
            const pid_t task = start_program({"bash", script_of(film, film.stages[s]).string(), std::to_string(k)});
            for (bool sent = false; waitpid(task, nullptr, WNOHANG) != task; std::this_thread::sleep_for(std::chrono::milliseconds(20)))
                if (interrupt.interrupted() && !std::exchange(sent, true)) kill(-task, SIGINT);  // a run saves its state then
            progress.show();
        }
    return !interrupt.interrupted();
}

/// Runs a program of Slurm. @return its output @throws EnvironmentError, with the output, if it fails
std::string said_by(const std::vector<std::string>& words) {
    try {
        ChildProcess child(words);
        const int code = child.wait();
        const std::string text = last_lines(child.output());
        if (code != 0) throw EnvironmentError(words[0] + " failed: " + text, "", "check with sinfo that Slurm runs");
        return text;
    } catch (const std::system_error& error) {
        throw EnvironmentError("cannot start " + words[0], error.what(), "use a machine with Slurm, or --on local");
    }
}

/// Submits all stages of the film as job arrays. Slurm starts each after the previous one, and cancels those that cannot begin.
/// @return the jobs: "7,8,9"
std::string submit(const FarmFilm& film, const FarmOptions& options) {
    std::string jobs, before;
    for (const FarmStage& stage : film.stages) {
        std::vector<std::string> words =
            words_of(fmt::format("sbatch --parsable --requeue --job-name=whorl-{} --array=0-{}{} --cpus-per-task={} --open-mode=append "
                                 "--time={:.0f} --mem={:.0f}M",
                                 stage.name, stage.tasks.size() - 1, options.jobs > 0 ? fmt::format("%{}", options.jobs) : "",
                                 options.threads, std::ceil(stage.seconds / 60), std::ceil(stage.bytes / 1048576)));
        words.push_back("--output=" + (film.folder / "farm" / (stage.name + ".%a.slurm")).string());
        if (!before.empty()) {
            words.push_back((stage.after_failures ? "--dependency=afterany:" : "--dependency=afterok:") + before);
            words.emplace_back("--kill-on-invalid-dep=yes");
        }
        words.insert(words.end(), options.sbatch.begin(), options.sbatch.end());
        words.push_back(script_of(film, stage).string());
        const std::string said = said_by(words);
        before = slurm_job(said);
        if (before.empty()) throw EnvironmentError("sbatch printed no job number: " + said, "", "check with sinfo that Slurm runs");
        jobs += (jobs.empty() ? "" : ",") + before;
        write_text(film.folder / "farm" / "jobs.txt", jobs + "\n");
    }
    return jobs;
}

/// Submits all films and waits until they have ended or Slurm has no more jobs of them. @return false if interrupted
bool run_on_slurm(const std::vector<FarmFilm>& films, const FarmOptions& options, const InterruptGuard& interrupt, FarmProgress& progress) {
    std::string jobs;
    for (const FarmFilm& film : films) jobs += (jobs.empty() ? "" : ",") + submit(film, options);
    for (int polls = 0, gone = 0; !std::all_of(films.begin(), films.end(), has_ended) && gone < 3; ++polls) {
        progress.show();
        if (interrupt.interrupted()) {
            fmt::print(stderr, "\nwhorl: the jobs {0} continue; scancel {0} ends them\n", jobs);
            return false;
        }
        // Every 3 s, so as not to burden Slurm. It gives up only after 3 queries, because files may appear after their job has ended, and
        // a query may fail.
        if (polls % 10 == 9) gone = slurm_jobs_live(jobs) ? 0 : gone + 1;
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    progress.show();
    return true;
}

}  // namespace

void check_farm(const FarmOptions& options) {
    if (options.on != "local" && options.on != "slurm") {
        const std::string near = nearest_name(options.on, {"local", "slurm"});
        throw InputError({"--on " + options.on, 0, 0}, "unknown location", near.empty() ? "" : "did you mean \"" + near + "\"?",
                         "allowed: local or slurm");
    }
    if (options.on == "slurm") said_by({"sbatch", "--version"});
    else if (!options.sbatch.empty() || options.jobs > 0)
        throw InputError({options.jobs > 0 ? "--jobs" : "--sbatch", 0, 0}, "has no effect with --on local", "add --on slurm, or remove it");
}

std::vector<FarmEnd> make_films(const std::vector<FarmFilm>& films, const FarmOptions& options, const InterruptGuard& interrupt) {
    for (const FarmFilm& film : films)
        for (const FarmStage& stage : film.stages) {
            write_script(film, stage, options.threads);
            for (std::size_t k = 0; k < stage.tasks.size(); ++k) fs::remove(file_of(film, stage, k, "code"));
        }
    FarmProgress progress(films, options.quiet);
    progress.show();
    if (options.on == "slurm" && !run_on_slurm(films, options, interrupt, progress)) return {};
    std::vector<FarmEnd> ends;
    for (const FarmFilm& film : films) ends.push_back(end_of(film, options.on == "local" && !run_here(film, interrupt, progress)));
    return ends;
}

}  // namespace whorl

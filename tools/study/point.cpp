#include "tools/study/point.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "engine/core/atomic_file.h"
#include "engine/core/clock.h"
#include "engine/core/utf8.h"
#include "engine/io/checkpoint.h"
#include "render/video/process.h"
#include "tools/process/json_text.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PointResult, status, message, cpu, wall, memory, frames, limit, made_by)

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int by_signal = 128;  ///< exit status of a program that a signal ended, minus the signal's number

struct ChildUse {
    int code = 0;  ///< exit status; -1: ended by the time limit
    double cpu = 0, wall = 0, memory = 0;
};

/// Runs a program with its output in a file until it ends, its time limit is reached, or the user interrupts.
ChildUse run_child(const std::vector<std::string>& arguments, const fs::path& output, double limit, const InterruptGuard& interrupt) {
    const double began = wall_seconds();
    const pid_t pid = start_program(arguments, output);
    rusage usage{};
    int status = 0;
    bool late = false;
    while (wait4(pid, &status, WNOHANG, &usage) == 0) {
        late = wall_seconds() - began > limit;
        if (late || interrupt.interrupted()) {
            kill(pid, SIGKILL);
            wait4(pid, &status, 0, &usage);
            break;
        }
        usleep(10000);
    }
    if (interrupt.interrupted()) throw StudyInterrupted();
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    const int code = WIFSIGNALED(status) ? by_signal + WTERMSIG(status) : WEXITSTATUS(status);
    return {late ? -1 : code, seconds(usage.ru_utime) + seconds(usage.ru_stime), wall_seconds() - began,
            1024.0 * static_cast<double>(usage.ru_maxrss)};
}

/// A readable folder name, with a hash that makes it unique.
std::string folder_name(const std::string& text) {
    std::string name;
    for (const char c : text)
        name +=
            static_cast<unsigned char>(c) >= 0x80 || std::isalnum(c) != 0 || std::string("=.-+_").find(c) != std::string::npos ? c : '_';
    if (name.size() > 100) name.resize(100);
    while (!is_utf8(name)) name.pop_back();  // part of a character
    return fmt::format("{}-{:08x}", name, static_cast<unsigned>(std::hash<std::string>{}(text)));
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// Hash of a run's input: the scene with its settings, and the files that it names. If the scene is invalid: of its file only.
std::size_t hash_of(const Options& options) {
    try {
        return input_hash(read_scene_file(options));
    } catch (const InputError&) {}
    try {
        return std::hash<std::string>()(text_of(find_scene(options.scene)));
    } catch (const InputError&) { return 0; }  // reported when the point runs
}

/// Message of a failed run. @param code exit status @param said the run's own message; may be empty
std::string failure(int code, const std::string& said) {
    const int signal = code - by_signal;
    if (signal <= 0 || signal >= NSIG || code == exit_interrupted)  // an interrupted run exits by itself
        return said.empty() ? fmt::format("ended with code {}", code) : said;
    return fmt::format("ended by signal {}{}{}{}", signal, signal == SIGKILL ? " (out of memory?)" : "", said.empty() ? "" : ": ", said);
}

/// Reuses an earlier result of the same call and build whose run is in the folder. Points that failed, and points that timed out under a
/// shorter limit, run again. @return whether the result is complete; false also if it has too few timings
bool take_record(const fs::path& record, int repeat, PointResult& result) try {
    auto known = json_of(record).get<PointResult>();
    const bool late = known.status == "timeout" && known.limit >= result.limit;
    const bool ended = (known.done() || known.status == "diverged") && json_of(result.folder / "run.json").at("status") == known.status;
    if (known.made_by != result.made_by || !(late || ended)) return false;
    known.folder = result.folder;
    result = std::move(known);
    return !result.done() || static_cast<int>(result.cpu.size()) >= repeat;
} catch (const Json::exception&) {
    return false;  // changed or removed: run the point again
}

}  // namespace

PointCall point_call(const Study& study, const std::string& scene, const std::vector<std::string>& settings) {
    PointCall call{joined_settings(settings), run_settings(study, settings), {}, {}, {}};
    call.options.scene = scene, call.options.quality = study.quality;
    for (const std::string& s : call.settings) {
        const std::string key = s.substr(0, s.find('=')), value = s.substr(key.size() + 1);
        if (key == "scene") call.options.scene = scene_of(study, value);
        else if (key == "quality") call.options.quality = value;
        else if (key == "program") call.program = fs::absolute(study.directory / value).string();
        else if (key == "threads") call.threads = value;
        else call.options.set.push_back(s);
    }
    return call;
}

namespace {

/// A text that is equal for runs with equal results and costs.
std::string identity_of(const PointCall& call, int threads, bool pictures) {
    Options read = call.options;
    read.no_images = !pictures, read.no_video = pictures;
    const std::string identity =
        fmt::format("{} {:016x} | {} | {} | {} threads{} | {}", read.scene, hash_of(read), joined_settings(call.settings), read.quality,
                    call.threads.empty() ? std::to_string(threads) : call.threads, pictures ? " | pictures" : "", build_id());
    if (call.program.empty()) return identity;
    std::error_code none;  // a missing program is reported when the point runs
    return identity + fmt::format(" | {} bytes of {}", fs::file_size(call.program, none),
                                  fs::last_write_time(call.program, none).time_since_epoch().count());
}

fs::path job_script(const fs::path& folder) { return folder / "points" / "job.sh"; }

/// Runs a point as a Slurm job and waits for its end. The point's time limit counts from the start of the job, without its time in the
/// queue.
/// @return exit status; -1: ended by the time limit @throws EnvironmentError if Slurm rejects the job
int run_job(const PointRunner& runner, const PointCall& call, const std::vector<std::string>& arguments, const fs::path& output) {
    const Study& study = runner.study;
    constexpr double to_begin = 300;  // s, added to the point's limit before Slurm ends the job
    const fs::path said = output.string() + ".job", script = job_script(runner.folder);
    std::vector<std::string> words = words_of("sbatch --wait --requeue --parsable --cpus-per-task=" + call.threads);
    words.insert(words.end(), {"--job-name=whorl-" + study.name, "--output=" + fs::absolute(output).string(),
                               fmt::format("--time={:.0f}", std::ceil((study.limit + to_begin) / 60))});
    words.insert(words.end(), runner.sbatch.begin(), runner.sbatch.end());
    words.insert(words.end(), {script.string(), "timeout", fmt::format("{:g}", study.limit)});
    words.insert(words.end(), arguments.begin(), arguments.end());
    try {
        const int code = run_child(words, said, std::numeric_limits<double>::infinity(), runner.interrupt).code;
        if (slurm_job(text_of(said)).empty())
            throw EnvironmentError("sbatch failed: " + text_of(said), "", "check with sinfo whether Slurm is running");
        constexpr int timeout_ended_it = 124;
        return code == timeout_ended_it ? -1 : code;
    } catch (const StudyInterrupted&) {
        if (const std::string job = slurm_job(text_of(said)); !job.empty()) ChildProcess({"scancel", job}).wait();
        throw;
    }
}

/// Runs the point once and adds its costs to the result.
void run_once(const PointRunner& runner, const PointCall& call, bool pictures, PointResult& result) {
    const Study& study = runner.study;
    const fs::path output = result.folder.string() + ".txt";
    std::vector<std::string> arguments{
        call.program, "render",    call.options.scene, "--out",     result.folder.string(), "--overwrite",
        "--quiet",    "--threads", call.threads,       "--quality", call.options.quality,   pictures ? "--no-video" : "--no-images"};
    for (const std::string& key : call.options.set) arguments.insert(arguments.end(), {"--set", key});
    fs::remove_all(result.folder);  // may exist from another build or timing; --overwrite serves restarted jobs
    const ChildUse use = runner.slurm ? ChildUse{.code = run_job(runner, call, arguments, output)}
                                      : run_child(arguments, output, study.limit, runner.interrupt);
    if (use.code == exit_bad_input)
        throw InputError({study.name, 0, 0}, fmt::format("the point {} cannot run: {}", call.name, text_of(output)));
    const Json run = json_of(result.folder / "run.json");
    const auto measured = [&](const char* name) { return run.is_object() ? run.value(name, 0.0) : 0.0; };
    const std::string status = run.is_object() ? run.value("status", "failed") : "failed";
    result.message = run.is_object() ? run.value("message", "") : text_of(output);
    if (use.code == -1) {
        result.status = "timeout", result.message = fmt::format("took longer than {:g} s", study.limit);
    } else if (use.code == exit_done) {
        result.status = "done";
    } else if (use.code == exit_failed && status == "diverged") {
        result.status = status;
    } else {
        result.status = "failed", result.message = failure(use.code, result.message);
    }
    // A job ran on another machine, so its own measurements count.
    result.cpu.push_back(runner.slurm ? measured("cpu_seconds") : use.cpu),
        result.wall.push_back(runner.slurm ? measured("wall_seconds") : use.wall);
    result.memory = std::max(result.memory, runner.slurm ? measured("peak_memory_bytes") : use.memory);
    result.frames = measured("frames_planned");
}

}  // namespace

void prepare_jobs(const fs::path& folder) {
    fs::create_directories(folder / "points");
    write_text(job_script(folder), "#!/bin/sh\n# Runs its arguments: sbatch needs a script.\nexec \"$@\"\n");
}

std::string joined_settings(const std::vector<std::string>& settings) { return fmt::format("{}", fmt::join(settings, ", ")); }

PointResult PointRunner::run(const std::string& scene, const std::vector<std::string>& settings, int repeat, bool pictures) const {
    PointCall call = point_call(study, scene, settings);
    PointResult result;
    result.limit = study.limit, result.made_by = identity_of(call, threads, pictures);
    result.folder =
        folder / "points" / folder_name(fs::path(call.options.scene).stem().string() + (call.name.empty() ? "" : "," + call.name));
    const fs::path record = result.folder.string() + ".json";
    if (take_record(record, repeat, result)) {
        result.kept = fs::last_write_time(record) < began;
        return result;
    }
    const bool own = !call.program.empty();
    if (!own) call.program = program_path().string();
    if (call.threads.empty()) call.threads = std::to_string(threads);
    if (access(call.program.c_str(), X_OK) != 0) {
        if (own)
            throw InputError({study.name, 0, 0}, fmt::format("the point {} cannot run: program {} not found", call.name, call.program),
                             "build it first: bash tools/build.sh PRESET whorl");
        throw EnvironmentError("the program " + call.program + " was removed", "",
                               "the program was removed or rebuilt during the study; start the study again");
    }
    fs::create_directories(folder / "points");
    fs::remove(record);  // run_once() deletes its run first
    do run_once(*this, call, pictures, result);
    while (result.done() && static_cast<int>(result.cpu.size()) < repeat);
    write_text(record, json_text(Json(result), 1) + "\n");
    return result;
}

}  // namespace whorl

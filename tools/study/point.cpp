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
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/core/clock.h"
#include "engine/core/utf8.h"
#include "engine/core/whole_file.h"
#include "engine/io/checkpoint.h"
#include "render/video/process.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int by_signal = 128;  ///< what shells and Slurm add to the number of the signal that ended a program

struct ChildUse {
    int code = 0;    ///< exit status; -1: it took too long
    int signal = 0;  ///< that ended it; 0: none
    double cpu = 0, wall = 0, memory = 0;
};

/// Runs a program with its output in a file, until it ends, its time is over, or the user interrupts.
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
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    return {late     ? -1
            : signal ? by_signal + signal
                     : WEXITSTATUS(status),
            signal, seconds(usage.ru_utime) + seconds(usage.ru_stime), wall_seconds() - began,
            1024.0 * static_cast<double>(usage.ru_maxrss)};
}

/// A folder name from settings: readable, and different for different settings.
std::string folder_name(const std::string& text) {
    std::string name;
    for (const char c : text)
        name +=
            static_cast<unsigned char>(c) >= 0x80 || std::isalnum(c) != 0 || std::string("=.-+_").find(c) != std::string::npos ? c : '_';
    if (name.size() > 100) name.resize(100);
    while (!is_utf8(name)) name.pop_back();  // half of a letter
    return fmt::format("{}-{:08x}", name, static_cast<unsigned>(std::hash<std::string>{}(text)));
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

Json json_of(const fs::path& file) { return Json::parse(text_of(file), nullptr, false); }

bool is_option(const std::string& setting, const char* name) { return setting.rfind(std::string(name) + "=", 0) == 0; }

/// Checksum of a run's input: the scene with its settings and the files that it names; if the scene cannot be read, of its file alone.
std::size_t hash_of(const Options& options) {
    const std::hash<std::string> hash;
    try {
        const SceneFile file = read_scene_file(options);
        std::string text = resolved_toml(file);
        const auto add = [&](const fs::path& named) {
            if (!named.empty()) text += fmt::format("\n{:x}", hash(text_of(named)));
        };
        for (const BlockKeys& block : file.scene.blocks) add(block.shape.file);
        for (const SolidKeys& solid : file.scene.solids) add(solid.shape.file);
        for (const DrainKeys& drain : file.scene.drains) add(drain.shape.file);
        add(file.look.environment);
        return hash(text);
    } catch (const InputError&) {}
    try {
        return hash(text_of(find_scene(options.scene)));
    } catch (const InputError&) { return 0; }  // reported when it is run
}

/// How a run failed. @param said its own words, if any
std::string failure(const ChildUse& use, const std::string& said) {
    if (!use.signal) return said.empty() ? fmt::format("ended with code {}", use.code) : said;
    return fmt::format("ended by signal {}{}{}{}", use.signal, use.signal == SIGKILL ? " (out of memory?)" : "", said.empty() ? "" : ": ",
                       said);
}

/// The signal that ended a job of Slurm's, taken from the exit status; 0: none.
int signal_of_job(int code) {
    const int number = code - by_signal;
    return number > 0 && number < NSIG && code != exit_interrupted ? number : 0;  // a run that saved its state ended by itself
}

/// Finds a record that can be reused: of the same call and build, timed often enough, with its run in the folder. Failed points may
/// succeed now, and late ones with more time. @return whether there is one
bool take_record(const fs::path& record, const std::string& identity, int repeat, double limit, PointResult& result) {
    const Json known = json_of(record);
    if (!known.is_object()) return false;
    PointResult kept{result};
    try {
        if (known.value("identity", "") != identity || known.value("build", "") != build_id()) return false;
        if (static_cast<int>(known.at("cpu_seconds").size()) < (known.at("status") == "done" ? repeat : 1)) return false;
        kept.status = known.at("status"), kept.message = known.at("message");
        if (kept.status == "timeout") {
            if (known.at("limit").get<double>() < limit) return false;
        } else if ((kept.status != "done" && kept.status != "diverged") || json_of(kept.folder / "run.json").at("status") != kept.status) {
            return false;
        }
        kept.cpu = known.at("cpu_seconds").get<std::vector<double>>(), kept.wall = known.at("wall_seconds").get<std::vector<double>>();
        kept.memory = known.at("memory_bytes"), kept.frames = known.at("frames");
    } catch (const Json::exception&) {
        return false;  // it was changed or removed: the point is run again
    }
    kept.kept = true;
    result = std::move(kept);
    return true;
}

void write_record(const fs::path& record, const std::string& identity, double limit, const PointResult& result) {
    const Json json{{"identity", identity},          {"build", build_id()},       {"status", result.status},
                    {"message", result.message},     {"cpu_seconds", result.cpu}, {"wall_seconds", result.wall},
                    {"memory_bytes", result.memory}, {"frames", result.frames},   {"limit", limit}};
    write_text(record, json_text(json, 1) + "\n");
}

}  // namespace

/// Command of a point.
struct PointRunner::Call {
    std::string program, threads;
    std::vector<std::string> all;  ///< settings
    Options options;
};

Options point_options(const Study& study, const std::string& scene, const std::vector<std::string>& settings) {
    Options options;
    options.scene = scene, options.quality = study.quality;
    for (const std::string& s : settings) {
        const std::string value = s.substr(s.find('=') + 1);
        if (is_option(s, "scene")) options.scene = scene_of(study, value);
        else if (is_option(s, "quality")) options.quality = value;
        else if (!is_option(s, "program") && !is_option(s, "threads")) options.set.push_back(s);
    }
    return options;
}

PointRunner::Call PointRunner::call_of(const Study& study, int threads, const std::string& scene, std::vector<std::string> settings) {
    Call call{program_path().string(), std::to_string(threads), std::move(settings), {}};
    call.options = point_options(study, scene, call.all);
    for (const std::string& s : call.all) {
        const std::string value = s.substr(s.find('=') + 1);
        if (is_option(s, "program")) call.program = fs::absolute(study.directory / value).string();
        else if (is_option(s, "threads")) call.threads = value;
    }
    return call;
}

/// Text that is equal for runs of equal result and cost.
std::string PointRunner::identity_of(const Call& call, bool pictures) {
    Options read = call.options;
    read.no_images = !pictures, read.no_video = pictures;
    std::string identity = fmt::format("{} {:016x} | {} | {} | {} threads{}", read.scene, hash_of(read), joined_settings(call.all),
                                       read.quality, call.threads, pictures ? " | pictures" : "");
    if (!name_a_program(call.all)) return identity;
    std::error_code none;  // a missing program is reported when it is run
    return identity + fmt::format(" | {} bytes of {}", fs::file_size(call.program, none),
                                  fs::last_write_time(call.program, none).time_since_epoch().count());
}

std::vector<std::string> PointRunner::arguments_of(const Call& call, bool pictures, const fs::path& folder) {
    std::vector<std::string> arguments{call.program, "render",    call.options.scene, "--out",     folder.string(),     "--overwrite",
                                       "--quiet",    "--threads", call.threads,       "--quality", call.options.quality};
    arguments.emplace_back(pictures ? "--no-video" : "--no-images");
    for (const std::string& key : call.options.set) arguments.emplace_back("--set"), arguments.push_back(key);
    return arguments;
}

bool name_a_program(const std::vector<std::string>& settings) {
    return std::any_of(settings.begin(), settings.end(), [](const std::string& s) { return is_option(s, "program"); });
}

std::string joined_settings(const std::vector<std::string>& settings) { return fmt::format("{}", fmt::join(settings, ", ")); }

PointRunner::PointRunner(const Study& study, fs::path folder, int threads, PointPlace place)
    : study_(study), folder_(std::move(folder)), threads_(threads), place_(std::move(place)) {
    if (!place_.slurm) return;
    fs::create_directories(folder_ / "points");
    write_text(folder_ / "points" / "job.sh", "#!/bin/sh\n# What sbatch runs for a point: the words behind it.\nexec \"$@\"\n");
}

PointResult PointRunner::run(const std::string& scene, const std::vector<std::string>& settings, int repeat, bool pictures) const {
    const Call call = call_of(study_, threads_, scene, run_settings(study_, settings));
    const std::string words = joined_settings(settings);
    PointResult result;
    result.folder = folder_ / "points" / folder_name(fs::path(call.options.scene).stem().string() + (words.empty() ? "" : "," + words));
    const fs::path record = result.folder.string() + ".json";
    std::unique_lock lock(mutex_);
    std::mutex& own = folders_[result.folder];
    lock.unlock();
    const std::lock_guard turn(own);  // another call for the same point waits, and finds what this one leaves
    const std::string identity = identity_of(call, pictures);
    if (take_record(record, identity, repeat, study_.limit, result)) {
        lock.lock();
        result.kept = !ran_.contains(result.folder);
        return result;
    }

    if (access(call.program.c_str(), X_OK) != 0) {
        if (!name_a_program(call.all))
            throw EnvironmentError("the program " + call.program + " was removed", "",
                                   "it was removed or rebuilt while the study ran: start the study again");
        throw InputError({study_.name, 0, 0}, fmt::format("the point {} cannot run: program {} not found", words, call.program),
                         "build it first: bash tools/build.sh PRESET whorl");
    }
    fs::create_directories(result.folder.parent_path());
    fs::remove(record);  // its run goes, too, also where this one is interrupted
    for (int k = 0; k < repeat && (k == 0 || result.done()); ++k) run_once(call, pictures, words, result);
    write_record(record, identity, study_.limit, result);
    lock.lock();
    ran_.insert(result.folder);
    return result;
}

/// Runs the program as a job and waits for its end. The point's limit counts from its start on a machine, not from when it is queued.
/// @return exit status; -1: it took too long @throws EnvironmentError if Slurm does not take it
int PointRunner::run_job(const Call& call, const std::vector<std::string>& arguments, const fs::path& output) const {
    constexpr double to_begin = 300;  // s: before Slurm itself ends the job
    const fs::path said = output.string() + ".job";
    std::vector<std::string> words{"sbatch",
                                   "--wait",
                                   "--requeue",
                                   "--parsable",
                                   "--job-name=whorl-" + study_.name,
                                   "--cpus-per-task=" + call.threads,
                                   "--output=" + fs::absolute(output).string(),
                                   fmt::format("--time={:.0f}", std::ceil((study_.limit + to_begin) / 60))};
    words.insert(words.end(), place_.sbatch.begin(), place_.sbatch.end());
    words.push_back((folder_ / "points" / "job.sh").string());
    for (const std::string& word : {std::string("timeout"), fmt::format("{:g}", study_.limit)}) words.push_back(word);
    words.insert(words.end(), arguments.begin(), arguments.end());
    try {
        const int code = run_child(words, said, std::numeric_limits<double>::infinity(), interrupt_).code;
        if (slurm_job(text_of(said)).empty()) throw EnvironmentError("sbatch failed: " + text_of(said), "", "is Slurm running? call sinfo");
        constexpr int timeout_ended_it = 124;
        return code == timeout_ended_it ? -1 : code;
    } catch (const StudyInterrupted&) {
        if (const std::string job = slurm_job(text_of(said)); !job.empty()) ChildProcess({"scancel", job}).wait();
        throw;
    }
}

/// Runs the point, and adds what it took to the result. @param words the point's name in messages
void PointRunner::run_once(const Call& call, bool pictures, const std::string& words, PointResult& result) const {
    const fs::path output = result.folder.string() + ".txt";
    const std::vector<std::string> arguments = arguments_of(call, pictures, result.folder);
    fs::remove_all(result.folder);  // of another build or timing; --overwrite is for a job that is begun again
    ChildUse use;
    if (place_.slurm) use.code = run_job(call, arguments, output), use.signal = signal_of_job(use.code);
    else use = run_child(arguments, output, study_.limit, interrupt_);
    if (use.code == exit_bad_input)
        throw InputError({study_.name, 0, 0}, fmt::format("the point {} cannot run: {}", words, text_of(output)));
    const Json run = json_of(result.folder / "run.json");
    if (place_.slurm && run.is_object())  // it ran on another machine: as it measured itself
        use.cpu = run.value("cpu_seconds", 0.0), use.wall = run.value("wall_seconds", 0.0),
        use.memory = run.value("peak_memory_bytes", 0.0);
    const bool late = use.code == -1;
    const std::string status = run.is_object() ? run.value("status", "failed") : "failed";
    result.status = late ? "timeout" : use.code == exit_done ? "done" : status == "diverged" ? status : "failed";
    if (use.code > exit_failed) result.status = "failed";
    result.message = run.is_object() ? run.value("message", "") : text_of(output);
    if (late) result.message = fmt::format("took longer than {:g} s", study_.limit);
    else if (result.status == "failed") result.message = failure(use, result.message);
    result.cpu.push_back(use.cpu), result.wall.push_back(use.wall);
    result.memory = std::max(result.memory, use.memory);
    result.frames = run.is_object() ? run.value("frames_planned", 0.0) : 0.0;
}

}  // namespace whorl

#include "tools/study/point.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/core/clock.h"
#include "engine/core/whole_file.h"
#include "engine/io/checkpoint.h"
#include "tools/program/command.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ChildUse {
    int code = 0;  ///< exit status; -1: it took too long
    double cpu = 0, wall = 0, memory = 0;
};

/// Runs a program with its output in a file, until it ends, its time is over, or the user interrupts.
ChildUse run_child(const std::vector<std::string>& arguments, const fs::path& output, double limit, const InterruptGuard& interrupt) {
    std::vector<char*> argv;
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    const double began = wall_seconds();
    const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    const pid_t pid = fork();
    if (pid < 0) throw EnvironmentError("a point could not be started");
    if (pid == 0) {
        setpgid(0, 0);  // the terminal's interrupt is for the study, which ends its points itself
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        dup2(file, STDOUT_FILENO);
        dup2(file, STDERR_FILENO);
        execvp(argv[0], argv.data());
        _exit(127);
    }
    close(file);
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
    return {late                ? -1
            : WIFEXITED(status) ? WEXITSTATUS(status)
                                : 128 + WTERMSIG(status),
            seconds(usage.ru_utime) + seconds(usage.ru_stime), wall_seconds() - began, 1024.0 * static_cast<double>(usage.ru_maxrss)};
}

/// A folder name from settings: readable, and different for different settings.
std::string folder_name(const std::string& text) {
    std::string name;
    for (const char c : text)
        name += std::isalnum(static_cast<unsigned char>(c)) || std::string("=.-+_").find(c) != std::string::npos ? c : '_';
    if (name.size() > 100) name.resize(100);
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

}  // namespace

bool name_a_program(const std::vector<std::string>& settings) {
    return std::any_of(settings.begin(), settings.end(), [](const std::string& s) { return is_option(s, "program"); });
}

std::string joined_settings(const std::vector<std::string>& settings) { return fmt::format("{}", fmt::join(settings, ", ")); }

PointRunner::PointRunner(const Study& study, fs::path folder, int threads) : study_(study), folder_(std::move(folder)), threads_(threads) {}

PointResult PointRunner::run(const std::string& scene, const std::vector<std::string>& settings, int repeat, bool pictures) const {
    const std::vector<std::string> all = run_settings(study_, settings);
    std::string program = fs::read_symlink("/proc/self/exe").string(), name = scene, quality = study_.quality,
                threads = std::to_string(threads_);
    std::vector<std::string> keys;
    for (const std::string& s : all) {
        const std::string value = s.substr(s.find('=') + 1);
        if (is_option(s, "program")) program = (study_.directory / value).string();
        else if (is_option(s, "scene")) name = value;
        else if (is_option(s, "quality")) quality = value;
        else if (is_option(s, "threads")) threads = value;
        else keys.push_back(s);
    }
    std::string identity =
        fmt::format("{} | {} | {} | {} threads{}", name, joined_settings(all), quality, threads, pictures ? " | pictures" : "");
    std::error_code none;  // a program that is not there is told below
    if (name_a_program(all))
        identity +=
            fmt::format(" | {} bytes of {}", fs::file_size(program, none), fs::last_write_time(program, none).time_since_epoch().count());
    PointResult result;
    const std::string words = joined_settings(settings);
    result.folder = folder_ / "points" / folder_name(fs::path(name).stem().string() + (words.empty() ? "" : "," + words));
    const fs::path record = result.folder.string() + ".json";

    const Json known = json_of(record);
    if (known.is_object() && known.value("identity", "") == identity && known.value("build", "") == build_id() &&
        static_cast<int>(known.at("cpu_seconds").size()) >= (known.at("status") == "done" ? repeat : 1)) {
        result.status = known.at("status"), result.message = known.at("message");
        result.cpu = known.at("cpu_seconds").get<std::vector<double>>(), result.wall = known.at("wall_seconds").get<std::vector<double>>();
        result.memory = known.at("memory_bytes"), result.frames = known.at("frames");
        result.kept = true;
        return result;
    }

    if (access(program.c_str(), X_OK) != 0)
        throw InputError({study_.name, 0, 0}, fmt::format("the point {} cannot run: there is no program {}", words, program),
                         "build it first: bash tools/build.sh PRESET whorl");
    std::vector<std::string> arguments{program,   "render",    name,    "--out",     result.folder.string(),
                                       "--quiet", "--threads", threads, "--quality", quality};
    arguments.emplace_back(pictures ? "--no-video" : "--no-images");
    for (const std::string& key : keys) arguments.emplace_back("--set"), arguments.push_back(key);
    fs::create_directories(result.folder.parent_path());
    const fs::path output = result.folder.string() + ".txt";
    for (int k = 0; k < repeat && (k == 0 || result.done()); ++k) {
        const ChildUse use = run_child(arguments, output, study_.limit, interrupt_);
        if (use.code == exit_bad_input)
            throw InputError({study_.name, 0, 0}, fmt::format("the point {} cannot run: {}", words, text_of(output)));
        const Json run = json_of(result.folder / "run.json");
        result.status = use.code == -1          ? "timeout"
                        : use.code == exit_done ? "done"
                        : run.is_object()       ? run.value("status", "failed")
                                                : "failed";
        if (use.code > exit_failed && use.code != -1) result.status = "failed";
        result.message = use.code == -1    ? fmt::format("took longer than {:g} s", study_.limit)
                         : run.is_object() ? run.value("message", "")
                                           : text_of(output);
        result.cpu.push_back(use.cpu), result.wall.push_back(use.wall);
        result.memory = std::max(result.memory, use.memory);
        result.frames = run.is_object() ? run.value("frames_planned", 0.0) : 0.0;
    }
    write_text(record, Json{{"identity", identity},
                            {"build", build_id()},
                            {"status", result.status},
                            {"message", result.message},
                            {"cpu_seconds", result.cpu},
                            {"wall_seconds", result.wall},
                            {"memory_bytes", result.memory},
                            {"frames", result.frames}}
                               .dump(1) +
                           "\n");
    return result;
}

}  // namespace whorl

#include "tools/film/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "engine/core/errors.h"
#include "engine/core/version.h"
#include "engine/scene/read.h"
#include "render/video/encoder.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"

namespace whorl {

namespace fs = std::filesystem;

namespace {

/// Whether a run wrote the file. @param scene name of the run's scene, which its videos have too; "" if it is unknown
bool is_of_a_run(const fs::path& file, const std::string& scene) {
    static const std::vector<std::string> names{
        "scene.resolved.toml", "run.json", "diagnostics.csv", "bodies.csv", "budget.csv", "contact.png", "log.txt", "probes", "frames",
        "checkpoints",         "panels"};
    const auto has = [](const std::vector<std::string>& all, const std::string& one) {
        return std::find(all.begin(), all.end(), one) != all.end();
    };
    return has(names, file.filename().string()) || has(export_kinds(), file.filename().string()) ||
           (file.stem().string() == scene && has(video_suffixes(), file.extension().string())) ||
           file.extension() == partial_video("film.mp4").extension();
}

std::vector<fs::path> files_of_run(const fs::path& path) {
    const std::string scene = report_of(path).value("scene", "");
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path))
        if (is_of_a_run(entry.path(), scene)) files.push_back(entry.path());
    return files;
}

bool has_files(const fs::path& folder) {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none))
        if (entry.path().filename().string().front() != '.') return true;
    return false;
}

/// Start time of the run, from the first line of its log. Distinguishes successive runs in the same folder.
std::string beginning_of(const fs::path& path) {
    std::string line;
    std::ifstream log(path / "log.txt");
    std::getline(log, line);
    return line.substr(0, line.find(']') + 1);
}

/// Slurm jobs that a farm started in the folder and that have not ended; "" if there are none.
std::string living_jobs(const fs::path& path) {
    std::ifstream in(path / "farm" / "jobs.txt");
    std::string jobs;
    return in >> jobs && slurm_jobs_live(jobs) ? jobs : "";
}

void make_folder(const fs::path& path) {
    if (fs::exists(path) && !fs::is_directory(path))
        throw InputError({path.string(), 0, 0}, "is a file, not a folder", "choose another folder with --out");
    std::error_code error;
    fs::create_directories(path, error);
    if (error) throw EnvironmentError("cannot make the folder " + path.string() + ": " + error.message(), "", "choose another with --out");
}

}  // namespace

nlohmann::json report_of(const fs::path& path) {
    nlohmann::json run = json_of(path / "run.json");
    if (!run.is_object()) return nlohmann::json::object();
    for (const char* const text : {"scene", "status", "drawn_from", "run_began"})
        if (run.contains(text) && !run[text].is_string()) run.erase(text);
    for (const char* const count : {"frames", "frames_planned", "frames_of_scene"})
        if (run.contains(count) && !run[count].is_number_unsigned()) run.erase(count);
    if (run.contains("draws") && !run["draws"].is_boolean()) run.erase("draws");
    return run;
}

bool is_run_folder(const fs::path& path) { return report_of(path).contains("whorl") || fs::exists(path / "scene.resolved.toml"); }

RunFolder::RunFolder(fs::path path, Hold hold) : path_(std::move(path)) {
    // The system releases this lock when the process ends for any reason.
    lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ < 0)
        throw EnvironmentError("cannot open the folder " + path_.string() + ": " + std::strerror(errno), "",
                               "choose another folder with --out");
    // A killed process keeps its lock until the system has freed its memory: try for two seconds.
    int taken = -1;
    for (int attempt = 0; attempt < 20 && taken != 0; ++attempt) {
        if (attempt > 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
        taken = ::flock(lock_, (hold == Hold::alone ? LOCK_EX : LOCK_SH) | LOCK_NB);
        if (taken != 0 && errno != EWOULDBLOCK) break;
    }
    if (taken == 0) return;
    if (errno == EWOULDBLOCK) {
        ::close(std::exchange(lock_, -1));
        if (hold == Hold::looking) return;
        throw InputError({path_.string(), 0, 0}, "another run is at work in this folder",
                         "wait for it, or choose another folder with --out");
    }
    fmt::print(stderr, "the disk of {} has no locks ({}): make sure that no other run uses this folder\n", path_.string(),
               std::strerror(errno));
}

RunFolder::RunFolder(RunFolder&& other) noexcept : path_(std::move(other.path_)), lock_(std::exchange(other.lock_, -1)) {}

RunFolder::~RunFolder() {
    if (lock_ >= 0) ::close(lock_);
}

/// Checks a folder that this process has locked. A farm locks only the subfolder farm, because its tasks lock the folder of the run.
void RunFolder::refuse(const fs::path& path, bool overwrite) {
    if (fs::exists(path / "farm") && !std::getenv("WHORL_FARM_TASK")) {
        const RunFolder held(path / "farm");
        if (const std::string jobs = living_jobs(path); !jobs.empty())
            throw InputError({path.string(), 0, 0}, "jobs of an earlier farm are at work in this folder: " + jobs,
                             fmt::format("squeue --jobs={0} shows them, scancel {0} ends them", jobs));
    }
    if (!is_run_folder(path)) {
        if (fs::is_empty(path)) return;
        throw InputError({path.string(), 0, 0}, "the folder contains files but no run (no run.json)", "choose another folder with --out");
    }
    if (!overwrite)
        throw InputError({path.string(), 0, 0}, "the folder already contains a run",
                         "choose another folder with --out, or replace the run with --overwrite");
}

void RunFolder::check_fresh(const fs::path& path, bool overwrite) {
    if (!fs::exists(path)) return;
    make_folder(path);
    const RunFolder held(path);
    refuse(path, overwrite);
}

RunFolder RunFolder::fresh(const fs::path& path, bool overwrite) {
    make_folder(path);
    RunFolder folder(path);
    refuse(path, overwrite);
    for (const fs::path& file : files_of_run(path))  // scene.resolved.toml marks the folder as a run until it is written again
        if (file.filename() != "scene.resolved.toml") fs::remove_all(file);
    return folder;
}

RunFolder RunFolder::existing(const fs::path& path, Hold hold) {
    const char* const allowed = "the folder of a run, as in out/honey_coil";
    if (fs::is_regular_file(path)) {
        const fs::path around = path.has_parent_path() ? path.parent_path() : ".";
        throw InputError({path.string(), 0, 0}, "is a file, not a folder", is_run_folder(around) ? "its run is " + around.string() : "",
                         allowed);
    }
    if (!fs::is_directory(path)) throw InputError({path.string(), 0, 0}, "folder not found", "", allowed);
    if (!is_run_folder(path)) throw InputError({path.string(), 0, 0}, "is not a run folder (no run.json)");
    return RunFolder(path, hold);
}

RunFolder RunFolder::drawing(const fs::path& path, const fs::path& of, const std::string& scene, Hold hold, bool overwrite) {
    make_folder(path);
    // As in run.json, also if the text is not valid UTF-8.
    const auto as_written = [](const std::string& text) { return nlohmann::json::parse(json_text(text)).get<std::string>(); };
    const std::string source = as_written(fs::canonical(of).string()), began = as_written(beginning_of(of));
    const auto is_marked = [&] {
        const nlohmann::json report = report_of(path);
        return report.value("drawn_from", "") == source && report.value("run_began", "") == began;
    };
    if (has_files(path) && !is_marked()) fresh(path, overwrite);
    RunFolder folder(path, hold);
    // Writes to a temporary name first, because another process may draw another range into the folder at the same time.
    const auto write = [&](const char* name, const std::string& text) {
        const fs::path temporary = path / fmt::format(".{}.{}", name, getpid());
        std::ofstream(temporary) << text;
        fs::rename(temporary, path / name);
    };
    const nlohmann::ordered_json mark{{"whorl", WHORL_VERSION},
                                      {"scene", report_of(of).value("scene", "")},
                                      {"status", "drawn"},
                                      {"drawn_from", source},
                                      {"run_began", began}};
    if (!is_marked()) write("run.json", json_text(mark, 2) + "\n");
    write("scene.resolved.toml", scene);
    return folder;
}

RunFolder RunFolder::any(const fs::path& path) {
    make_folder(path);
    return RunFolder(path);
}

}  // namespace whorl

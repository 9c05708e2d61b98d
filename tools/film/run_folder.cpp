#include "tools/film/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/core/errors.h"
#include "engine/scene/scene_keys.h"

namespace whorl {

namespace fs = std::filesystem;

bool is_run_folder(const fs::path& path) {
    std::ifstream in(path / "run.json");
    const auto run = nlohmann::json::parse(in, nullptr, false);
    return (run.is_object() && run.contains("whorl")) || fs::exists(path / "scene.resolved.toml");
}

namespace {

/// Renames the folder to NAME.1, or the first number that is free. @return the new name
fs::path set_aside(const fs::path& path) {
    fs::path plain = path.lexically_normal();
    if (!plain.has_filename()) plain = plain.parent_path();  // "out/honey/"
    fs::path kept;
    for (int k = 1; kept.empty() || fs::exists(kept); ++k) kept = plain.string() + "." + std::to_string(k);
    std::error_code error;
    fs::rename(plain, kept, error);
    if (error)
        throw EnvironmentError("cannot rename the run that stands in " + path.string() + " to " + kept.string() + ": " + error.message(),
                               "", "choose another folder with --out, or replace the run with --overwrite");
    return kept;
}

}  // namespace

RunFolder::RunFolder(fs::path path, Hold hold) : path_(std::move(path)) {
    // The lock goes with the process, however it ends.
    lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ >= 0 && ::flock(lock_, (hold == Hold::alone ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0) return;
    if (lock_ >= 0) ::close(lock_);
    throw InputError({path_.string(), 0, 0}, "another run is at work in this folder", "wait for it, or choose another folder with --out");
}

RunFolder::RunFolder(RunFolder&& other) noexcept : path_(std::move(other.path_)), note_(std::move(other.note_)), lock_(other.lock_) {
    other.lock_ = -1;
}

RunFolder::~RunFolder() {
    if (lock_ >= 0) ::close(lock_);
}

RunFolder RunFolder::fresh(const fs::path& path, Earlier earlier) {
    const Place place{path.string(), 0, 0};
    if (fs::exists(path) && !fs::is_directory(path)) throw InputError(place, "is a file, not a folder", "choose another folder with --out");
    const bool used = fs::exists(path) && !fs::is_empty(path);
    if (used && !is_run_folder(path))
        throw InputError(place, "the folder holds files that are not of a run (no run.json)", "choose another folder with --out");
    std::string note;
    if (used && earlier == Earlier::kept) {
        const RunFolder held(path);  // nobody is at work in it
        note = "the run that stood in " + path.string() + " is now in " + set_aside(path).string();
    }
    std::error_code error;
    fs::create_directories(path, error);
    if (error) throw EnvironmentError("cannot make the folder " + path.string() + ": " + error.message(), "", "choose another with --out");
    RunFolder folder(path);
    folder.note_ = note;
    if (!used || earlier == Earlier::kept) return folder;
    folder.note_ = "the run that stood in " + path.string() + " is replaced";
    for (const char* name : {"scene.resolved.toml", "run.json", "diagnostics.csv", "bodies.csv", "contact.png", "log.txt", "probes",
                             "frames", "checkpoints", "panels"})
        fs::remove_all(path / name);
    for (const std::string& kind : export_kinds()) fs::remove_all(path / kind);
    for (const auto& entry : fs::directory_iterator(path))
        if (entry.path().extension() == ".mp4") fs::remove(entry.path());
    return folder;
}

RunFolder RunFolder::existing(const fs::path& path, Hold hold) {
    if (!fs::is_directory(path))
        throw InputError({path.string(), 0, 0}, "there is no such folder", "", "the folder of a run, as in out/honey_coil");
    if (!is_run_folder(path)) throw InputError({path.string(), 0, 0}, "no run folder (it has no run.json)");
    return RunFolder(path, hold);
}

}  // namespace whorl

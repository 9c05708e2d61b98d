#pragma once
/// Folder of a run: out/<scene>/ or --out.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace whorl {

/// Locks the folder of a run while the object exists. On a disk without locks it prints a warning instead.
class RunFolder {
public:
    /// Creates and locks the folder of a new run. With `overwrite` it deletes the files of an existing run; other files stay, such as
    /// videos with other names. @throws InputError as check_fresh(); EnvironmentError if the folder cannot be created
    static RunFolder fresh(const std::filesystem::path& path, bool overwrite);
    /// Checks whether a new run can use the folder; writes nothing. @throws InputError if the folder contains a run and `overwrite` is
    /// false, if it contains files but no run, or if another process or the jobs of a farm use it
    static void check_fresh(const std::filesystem::path& path, bool overwrite);
    /// Kind of lock: `alone` excludes all others, `shared` excludes only `alone`, `looking` is as `shared` but does not fail.
    enum class Hold { alone, shared, looking };
    /// Opens and locks the folder of an existing run. If `hold` is `looking` and another process has the lock, is_held() is false.
    /// @throws InputError if the folder contains no run, or if another process has the lock (see Hold)
    static RunFolder existing(const std::filesystem::path& path, Hold hold = Hold::alone);
    /// Creates and locks a folder for images of the run in `of`, marks it as drawn from that run, and writes `scene`, the resolved scene
    /// with the latest look. Images of the same run that are already there stay. @throws as fresh()
    static RunFolder drawing(const std::filesystem::path& path, const std::filesystem::path& of, const std::string& scene, Hold hold,
                             bool overwrite);
    /// Creates and locks a folder, whatever it contains. @throws InputError if another process has the lock; EnvironmentError if the folder
    /// cannot be created
    static RunFolder any(const std::filesystem::path& path);
    ~RunFolder();
    RunFolder(RunFolder&& other) noexcept;

    bool is_held() const { return lock_ >= 0; }
    const std::filesystem::path& path() const { return path_; }

private:
    explicit RunFolder(std::filesystem::path path, Hold hold = Hold::alone);
    static void refuse(const std::filesystem::path& path, bool overwrite);
    std::filesystem::path path_;
    int lock_ = -1;
};

/// Content of the folder's run.json; empty if there is none. Omits entries (names, state, numbers of frames) whose JSON type is wrong.
nlohmann::json report_of(const std::filesystem::path& path);

/// Whether the folder contains a run, even one that was killed at its start: Whorl's run.json or scene.resolved.toml.
bool is_run_folder(const std::filesystem::path& path);

}  // namespace whorl

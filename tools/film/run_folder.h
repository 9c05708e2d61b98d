#pragma once
/// The folder of a run: out/<scene>/ or --out.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace whorl {

/// Locks the folder for one process at a time. On a disk without locks it warns instead.
class RunFolder {
public:
    /// Makes the folder of a new run. With `overwrite` the files of a run in it are deleted; other files stay, such as videos of other
    /// names. @throws InputError as check_fresh(); EnvironmentError if it cannot be made
    static RunFolder fresh(const std::filesystem::path& path, bool overwrite);
    /// Writes nothing. @throws InputError if the folder has a run and `overwrite` is false, if it has files of something else, or if
    /// another process or a farm's jobs work in it
    static void check_fresh(const std::filesystem::path& path, bool overwrite);
    enum class Hold { alone, shared, looking };
    /// Opens a run to continue it; `looking`: also one in which another process works (then is_held() is false). @throws InputError if
    /// there is no run, or another process works in it (unless both use `shared`)
    static RunFolder existing(const std::filesystem::path& path, Hold hold = Hold::alone);
    /// Opens a folder for images of another run: makes it, marks it as drawn from that run, and writes the scene of the last drawing.
    /// Images of the same run are added to existing ones. @throws as fresh()
    static RunFolder drawing(const std::filesystem::path& path, const std::filesystem::path& of, const std::string& scene, Hold hold,
                             bool overwrite);
    /// Any folder, which is made. @throws as fresh()
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

/// The folder's run.json; empty if it does not exist. Names, states and counts of frames that are no such values are left out.
nlohmann::json report_of(const std::filesystem::path& path);

/// Whether the folder holds a run of Whorl's, or the remains of one that was killed at its start.
bool is_run_folder(const std::filesystem::path& path);

}  // namespace whorl

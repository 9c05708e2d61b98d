#pragma once
/// The folder of a run: out/<scene>/ or --out.
#include <filesystem>

namespace whorl {

/// Holds the folder for one process at a time.
class RunFolder {
public:
    /// A new run: makes the folder. One that stands already is taken only where it is empty or a run folder (it has a run.json of Whorl's):
    /// then the files of the run before it go, others stay.
    /// @throws InputError where it is something else, or another process is at work in it; EnvironmentError where it cannot be made
    static RunFolder fresh(const std::filesystem::path& path);
    /// A run to go on with. @throws InputError where there is none, or another process is at work in it
    static RunFolder existing(const std::filesystem::path& path);
    ~RunFolder();
    RunFolder(RunFolder&& other) noexcept;

    const std::filesystem::path& path() const { return path_; }

private:
    explicit RunFolder(std::filesystem::path path);
    std::filesystem::path path_;
    int lock_ = -1;
};

/// Whether the folder holds a run of Whorl's.
bool is_run_folder(const std::filesystem::path& path);

}  // namespace whorl

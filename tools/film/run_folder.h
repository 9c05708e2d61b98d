#pragma once
/// The folder of a run: out/<scene>/ or --out.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace whorl {

/// Locks the folder for one process at a time.
class RunFolder {
public:
    enum class Earlier { kept, replaced, begun_again };
    /// A new run: makes the folder. `kept`: a run that is already there is renamed to NAME.1, or the first number that is free. `replaced`:
    /// its files are deleted; other files stay, such as videos of other names. `begun_again`: the same, but a run with frames is kept.
    /// @throws InputError if it holds something that is not a run, or another process or a farm's jobs work in it; EnvironmentError if it
    /// cannot be made
    static RunFolder fresh(const std::filesystem::path& path, Earlier earlier = Earlier::kept);
    /// Refuses what fresh() refuses, and writes nothing. @throws InputError as fresh()
    static void check_fresh(const std::filesystem::path& path);
    enum class Hold { alone, shared, looking };
    /// Opens a run to continue it; `looking`: also one in which another process works (then is_held() is false). @throws InputError if
    /// there is no run, or another process works in it (unless both use `shared`)
    static RunFolder existing(const std::filesystem::path& path, Hold hold = Hold::alone);
    /// Opens a folder for images of another run: makes it, marks it as drawn from that run, and writes the scene of the last drawing.
    /// Images of the same run are added to existing ones; a run, or images of an earlier run in the place of this one,
    /// are kept under another name. @throws as fresh()
    static RunFolder drawing(const std::filesystem::path& path, const std::filesystem::path& of, const std::string& scene, Hold hold);
    /// Any folder, which is made. @throws as fresh()
    static RunFolder any(const std::filesystem::path& path);
    ~RunFolder();
    RunFolder(RunFolder&& other) noexcept;

    bool is_held() const { return lock_ >= 0; }
    const std::filesystem::path& path() const { return path_; }
    /// Fate of an earlier run, and other remarks, as sentences; empty without remarks.
    const std::string& note() const { return note_; }

private:
    explicit RunFolder(std::filesystem::path path, Hold hold = Hold::alone);
    void keep();
    static void refuse_farm(const std::filesystem::path& path);
    void add_note(const std::string& sentence);
    std::filesystem::path path_;
    std::string note_;
    int lock_ = -1;
};

/// The folder's run.json; empty if it does not exist. Names, states and counts of frames that are no such values are left out.
nlohmann::json report_of(const std::filesystem::path& path);

/// Whether the folder holds a run of Whorl's, or the remains of one that was killed at its start.
bool is_run_folder(const std::filesystem::path& path);

}  // namespace whorl

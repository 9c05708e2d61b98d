#pragma once
/// recording.toml: the scene and every change with its simulated time. `whorl render recording.toml` repeats the run.
#include <filesystem>
#include <string>
#include <vector>

#include "tools/scene_file/scene_changes.h"

namespace whorl {

class Journal {
public:
    explicit Journal(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// A run begins with this scene. @param path of the scene file, whose text is kept (with its qualities); @param quality that is laid
    /// over it
    void begin(const SceneFile& scene, const std::filesystem::path& path, const std::string& quality);
    /// At `time` [s] these keys took other values.
    void add(double time, const std::vector<KeyChange>& changes);
    /// @param time s, what the recording lasts until
    std::string text(double time) const;
    /// @throws EnvironmentError (disk full)
    void write(double time) const;
    const std::filesystem::path& folder() const { return folder_; }
    std::filesystem::path file() const { return folder_ / "recording.toml"; }

private:
    struct Entry {
        double time;
        std::string key, value;
    };
    std::filesystem::path folder_;
    std::string name_, quality_, base_;
    std::vector<Entry> entries_;
};

}  // namespace whorl

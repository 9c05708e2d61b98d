#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace whorl::test {

/// A new folder that is deleted with its owner.
class ScratchFolder {
public:
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// Names under which `work` created files in a folder, in order; without names that renaming gave them later.
std::vector<std::string> names_made(const std::filesystem::path& folder, const std::function<void()>& work);

}  // namespace whorl::test

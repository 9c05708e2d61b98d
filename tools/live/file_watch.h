#pragma once
/// Tells when a file was saved.
#include <atomic>
#include <filesystem>
#include <functional>
#include <thread>

namespace whorl {

/// Checks the file four times a second, on its own thread; waits until a file that is being written is complete.
class FileWatch {
public:
    /// @param file called at each check: the scene may change @param saved called on the watch's thread
    FileWatch(std::function<std::filesystem::path()> file, std::function<void()> saved);
    ~FileWatch();
    FileWatch(const FileWatch&) = delete;
    FileWatch& operator=(const FileWatch&) = delete;

private:
    std::atomic<bool> ending_{false};
    std::thread thread_;
};

}  // namespace whorl

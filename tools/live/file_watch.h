#pragma once
/// Tells when a file was saved.
#include <atomic>
#include <filesystem>
#include <functional>
#include <thread>

namespace whorl {

/// Looks at the file four times a second, on a thread of its own; a file that is just being written is waited for.
class FileWatch {
public:
    /// @param file asked anew each time: the scene may become another one @param saved called on the watch's thread
    FileWatch(std::function<std::filesystem::path()> file, std::function<void()> saved);
    ~FileWatch();
    FileWatch(const FileWatch&) = delete;
    FileWatch& operator=(const FileWatch&) = delete;

private:
    std::atomic<bool> ending_{false};
    std::thread thread_;
};

}  // namespace whorl

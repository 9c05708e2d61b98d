#include <sys/stat.h>

#include <array>
#include <chrono>

#include "tools/live/controls.h"
#include "tools/process/process.h"

namespace whorl {
namespace {

/// Inode, size and time of the last change of a file, which differ after every save; zeros if the file does not exist (an editor may be
/// replacing it).
std::array<long, 4> stamp(const std::filesystem::path& file) {
    struct stat s {};
    if (stat(file.c_str(), &s) != 0) return {};
    return {static_cast<long>(s.st_ino), static_cast<long>(s.st_size), s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
}

}  // namespace

std::jthread watch_file(std::function<std::filesystem::path()> file, std::function<void()> saved) {
    return std::jthread([file = std::move(file), saved = std::move(saved)](const std::stop_token& ending) {
        name_thread("watch");
        std::filesystem::path watched = file();
        auto known = stamp(watched), last = known;
        while (!ending.stop_requested()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(125));
            if (const auto now = file(); now != watched) watched = now, known = last = stamp(now);
            const auto seen = stamp(watched);
            const bool settled = seen == last && seen != decltype(seen){};
            last = seen;
            if (!settled || seen == known) continue;
            known = seen;
            saved();
        }
    });
}

}  // namespace whorl

#include "tests/support/scratch.h"

#include <sys/inotify.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace whorl::test {

ScratchFolder::ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "whorl-test-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
    path_ = name;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::vector<std::string> names_made(const std::filesystem::path& folder, const std::function<void()>& work) {
    const int watch = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    if (watch < 0 || inotify_add_watch(watch, folder.c_str(), IN_CREATE) < 0) throw std::runtime_error("cannot watch " + folder.string());
    work();
    std::vector<std::string> names;
    std::vector<char> events(1 << 16);
    for (ssize_t size; (size = read(watch, events.data(), events.size())) > 0;)
        for (ssize_t at = 0; at < size;) {
            inotify_event event{};
            std::memcpy(&event, events.data() + at, sizeof event);
            names.emplace_back(events.data() + at + sizeof event);
            at += static_cast<ssize_t>(sizeof event + event.len);
        }
    close(watch);
    return names;
}

}  // namespace whorl::test

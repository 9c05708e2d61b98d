#include "tools/process/program_path.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <sstream>

#include "engine/core/errors.h"

namespace whorl {

namespace fs = std::filesystem;

fs::path program_called(const std::string& word, const std::string& folders) {
    const auto runs = [](const fs::path& file) {
        std::error_code ignored;
        return fs::is_regular_file(file, ignored) && ::access(file.c_str(), X_OK) == 0;
    };
    if (word.find('/') != std::string::npos) return runs(word) ? fs::absolute(word) : fs::path();
    std::istringstream in(folders);
    for (std::string folder; std::getline(in, folder, ':');)
        if (const fs::path file = fs::path(folder.empty() ? "." : folder) / word; runs(file)) return fs::absolute(file);
    return {};
}

fs::path program_path() {
    std::error_code error;
    if (const fs::path file = fs::read_symlink("/proc/self/exe", error); !error) return file;
    const char* folders = std::getenv("PATH");
    const fs::path file = program_called(program_invocation_name, folders ? folders : "");
    if (!file.empty()) return file;
    throw EnvironmentError("cannot tell which file this program is: /proc/self/exe cannot be read (" + error.message() + "), and \"" +
                               program_invocation_name + "\" is not found",
                           "", "mount /proc, or call the program by its whole path");
}

}  // namespace whorl

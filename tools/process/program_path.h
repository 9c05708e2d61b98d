#pragma once
/// Which file the running program is: to start it again, and to find what is installed beside it.
#include <filesystem>
#include <string>

namespace whorl {

/// As the kernel says (/proc/self/exe); where there is no /proc, as the program was called. @throws EnvironmentError where neither tells
std::filesystem::path program_path();

/// The file that a shell runs for this word. @param word a path with a slash in it, or a name that is looked for @param folders where to
/// look, with colons between them, as in PATH @return "" where there is none
std::filesystem::path program_called(const std::string& word, const std::string& folders);

}  // namespace whorl

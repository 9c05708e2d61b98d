#pragma once
/// Three kinds of failure (docs/architecture.md): invalid input, a failing environment, an internal bug. A diverging run is not a
/// failure but a result (StepReport::diverged).
#include <stdexcept>
#include <string>
#include <vector>

namespace whorl {

/// Location of a mistake in a file; line and column count from 1, 0: not known (a command line option, for example).
struct FileLocation {
    std::string file;
    int line = 0;
    int column = 0;
};

/// One mistake of the user: "file:line:column: what is wrong; did you mean X?; what is allowed".
struct Problem {
    FileLocation place;
    std::string what;     ///< what is wrong, with the value
    std::string hint;     ///< the nearest valid name or the way out; may be empty
    std::string allowed;  ///< what is allowed; may be empty
    std::string message() const;
};

/// Problems in the order in which people read them: the main file's by line and column, then those of the command line; each once.
std::vector<Problem> in_order(std::vector<Problem> problems, const std::string& main_file);

/// The user's mistakes, all that were found in one go. Exit code 2.
class InputError : public std::runtime_error {
public:
    explicit InputError(std::vector<Problem> problems);
    InputError(FileLocation place, std::string what, std::string hint = "", std::string allowed = "");
    const std::vector<Problem>& problems() const { return problems_; }

private:
    std::vector<Problem> problems_;
};

/// The world's failure: no EGL device, disk full, ffmpeg missing. Exit code 1.
class EnvironmentError : public std::runtime_error {
public:
    /// @param what the failure @param tried the attempts, in order @param remedy what to install or free
    EnvironmentError(std::string what, std::string tried = "", std::string remedy = "");
};

/// The closest of `names` to `word` by edit distance (a beginning counts as close), or "" where none is near enough to be meant.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

}  // namespace whorl

/// Our own failure: stops the program with the condition, the place and the numbers.
#define WHORL_ASSERT(condition, ...)                                                                 \
    do {                                                                                             \
        if (!(condition)) ::whorl::assertion_failed(#condition, __FILE__, __LINE__, "" __VA_ARGS__); \
    } while (false)

namespace whorl {
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line, const std::string& numbers);
}

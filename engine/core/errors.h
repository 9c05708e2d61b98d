#pragma once
/// Three kinds of failure (docs/architecture.md): invalid input, a failing environment, an internal bug. A diverging run is not a
/// failure but a result (StepReport::diverged).
#include <stdexcept>
#include <string>
#include <vector>

namespace whorl {

/// Location in a file. Line and column count from 1; 0: unknown (a command line option, for example).
struct FileLocation {
    std::string file;
    int line = 0;
    int column = 0;
};

/// One mistake in the input. message(): "file:line:column: what is wrong; did you mean X?; what is allowed".
struct Problem {
    FileLocation place;
    std::string what;     ///< the fault, with the value
    std::string hint;     ///< the nearest valid name or a fix; may be empty
    std::string allowed;  ///< the allowed values; may be empty
    std::string message() const;
};

/// Problems sorted for reading: those of the main file by line and column, then those of the command line. Duplicates are removed.
std::vector<Problem> in_order(std::vector<Problem> problems, const std::string& main_file);

/// Invalid input: all mistakes that one check found. Exit code 2.
class InputError : public std::runtime_error {
public:
    explicit InputError(std::vector<Problem> problems);
    InputError(FileLocation place, std::string what, std::string hint = "", std::string allowed = "");
    const std::vector<Problem>& problems() const { return problems_; }

private:
    std::vector<Problem> problems_;
};

/// Failure of the environment: no EGL device, disk full, ffmpeg missing. Exit code 1.
class EnvironmentError : public std::runtime_error {
public:
    /// @param what the failure @param tried the attempts, in order @param remedy the fix: what to install or free
    EnvironmentError(std::string what, std::string tried = "", std::string remedy = "");
};

/// The entry of `names` with the smallest edit distance to `word`. An entry that begins with `word` has distance 1. "" if all are too far.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

}  // namespace whorl

/// Internal error: stops the program and prints the condition, its file and line, and the values.
#define WHORL_ASSERT(condition, ...)                                                                 \
    do {                                                                                             \
        if (!(condition)) ::whorl::assertion_failed(#condition, __FILE__, __LINE__, "" __VA_ARGS__); \
    } while (false)

namespace whorl {
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line, const std::string& numbers);
}

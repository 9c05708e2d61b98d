#pragma once
/// A program that is run without a shell and gets data through its standard input.
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace whorl {

/// A child process in its own process group. An interrupt from the terminal reaches only Whorl, which then ends its children in order. If
/// Whorl is killed, the child reads the end of its input and finishes by itself.
class ChildProcess {
public:
    /// Starts arguments[0], looked up in PATH. @throws std::system_error (ENOENT: no such program)
    explicit ChildProcess(const std::vector<std::string>& arguments);
    ~ChildProcess();
    ChildProcess(ChildProcess&& other) noexcept;

    /// Writes all bytes; waits while the child reads more slowly. Never raises SIGPIPE. @return false if the child has stopped reading
    bool write(std::span<const std::uint8_t> bytes);
    /// Ends the child's input and waits for the child. @return its exit status, or 128 + the number of the signal that ended it
    int wait();
    /// Number of the signal that ended the child; 0 if no signal did, or if wait() has not returned yet.
    int ended_by() const { return signal_; }
    /// The child's standard output and standard error so far.
    std::string output() const;

private:
    pid_t pid_ = -1;
    int input_ = -1, output_ = -1, signal_ = 0;
};

/// Splits a command line at its spaces.
std::vector<std::string> words_of(const std::string& line);
/// The last `most` bytes of a program's output, without line ends at the end.
std::string last_lines(std::string output, std::size_t most = 600);

}  // namespace whorl

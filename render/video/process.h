#pragma once
/// A program run without a shell, fed through its standard input.
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace whorl {

/// A child process in its own process group: an interrupt from the terminal reaches only Whorl, which then ends its children in order;
/// and if Whorl is killed, the child reads the end of its input and finishes by itself.
class ChildProcess {
public:
    /// Starts arguments[0], looked up in PATH. @throws std::system_error (ENOENT: no such program)
    explicit ChildProcess(const std::vector<std::string>& arguments);
    ~ChildProcess();
    ChildProcess(ChildProcess&& other) noexcept;

    /// Writes all of it, waiting where the child is slower. @return false if the child no longer reads; never raises SIGPIPE.
    bool write(std::span<const std::uint8_t> bytes);
    /// Ends the child's input and waits for it. @return its exit status, 128 + the signal's number where a signal ended it
    int wait();
    /// The signal that ended it; 0: none, or it has not ended.
    int ended_by() const { return signal_; }
    /// Standard output and standard error of the child up to now.
    std::string output() const;

private:
    pid_t pid_ = -1;
    int input_ = -1, output_ = -1, signal_ = 0;
};

}  // namespace whorl

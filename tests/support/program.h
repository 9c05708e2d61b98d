#pragma once
/// The built program, run as a user runs it.
#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace whorl::test {

struct Outcome {
    int code = 0;  ///< exit status; 128 + the signal's number if a signal ended it
    std::string out, err;
};

class Program {
public:
    /// Starts whorl with these arguments, or another program if its name is given.
    explicit Program(const std::vector<std::string>& arguments, const std::string& program = WHORL_PROGRAM);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    /// Waits until the condition holds. @return false if the program ends before, or after five minutes
    bool wait_until(const std::function<bool()>& condition);
    void signal(int number) const;
    /// Its standard output up to now.
    std::string output() const;
    pid_t id() const { return pid_; }
    Outcome wait();

private:
    pid_t pid_ = -1;
    int out_ = -1, err_ = -1, status_ = 0;
    bool ended_ = false;
};

inline Outcome whorl(const std::vector<std::string>& arguments) { return Program(arguments).wait(); }
/// The outcome of a success. @throws std::runtime_error with the output if the exit status is not 0
Outcome succeed(Outcome outcome);
inline Outcome succeed(const std::vector<std::string>& arguments) { return succeed(whorl(arguments)); }
/// Standard error. @throws std::runtime_error with the output if the exit status is not 2
std::string refusal(const Outcome& outcome);
inline std::string refusal(const std::vector<std::string>& arguments) { return refusal(whorl(arguments)); }

}  // namespace whorl::test

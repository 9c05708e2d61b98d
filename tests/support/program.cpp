#include "tests/support/program.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <thread>

namespace whorl::test {
namespace {

std::string content(int descriptor) {
    std::string text;
    char buffer[4096];
    for (off_t at = 0;;) {
        const ssize_t got = pread(descriptor, buffer, sizeof buffer, at);
        if (got <= 0) return text;
        text.append(buffer, got);
        at += got;
    }
}

}  // namespace

Program::Program(const std::vector<std::string>& arguments, const std::string& program)
    : out_(memfd_create("out", MFD_CLOEXEC)), err_(memfd_create("err", MFD_CLOEXEC)) {
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
        dup2(out_, STDOUT_FILENO);
        dup2(err_, STDERR_FILENO);
        execvp(argv[0], argv.data());
        _exit(127);
    }
}

Program::~Program() {
    if (!ended_) {
        signal(SIGKILL);
        wait();
    }
    close(out_);
    close(err_);
}

std::string Program::output() const { return content(out_); }

void Program::signal(int number) const { kill(pid_, number); }

bool Program::wait_until(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    while (std::chrono::steady_clock::now() < end) {
        if (condition()) return true;
        if (waitpid(pid_, &status_, WNOHANG) == pid_) {
            ended_ = true;
            return condition();
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
}

Outcome Program::wait() {
    if (!ended_) waitpid(pid_, &status_, 0);
    ended_ = true;
    return {WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_), content(out_), content(err_)};
}

namespace {

void check_code(const Outcome& outcome, int code) {
    if (outcome.code != code) throw std::runtime_error("exit status " + std::to_string(outcome.code) + ": " + outcome.err + outcome.out);
}

}  // namespace

Outcome succeed(Outcome outcome) {
    check_code(outcome, 0);
    return outcome;
}

std::string refusal(const Outcome& outcome) {
    check_code(outcome, 2);
    return outcome.err;
}

}  // namespace whorl::test

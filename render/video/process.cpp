#include "render/video/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <iterator>
#include <sstream>
#include <system_error>
#include <utility>

extern char** environ;

namespace whorl {

ChildProcess::ChildProcess(const std::vector<std::string>& arguments) {
    // A socket instead of a pipe, because send() can suppress SIGPIPE. Close-on-exec, because the child never reads the end of its input
    // while another child has our end open.
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        throw std::system_error(errno, std::generic_category(), "socketpair");
    output_ = memfd_create("output", MFD_CLOEXEC);

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, output_, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, output_, STDERR_FILENO);

    // The child handles signals by default even if our threads block or ignore them.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, ordinary;
    sigemptyset(&none);
    sigemptyset(&ordinary);
    for (int signal : {SIGINT, SIGTERM, SIGPIPE, SIGHUP}) sigaddset(&ordinary, signal);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &ordinary);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

    std::vector<char*> argv;
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    const int error = posix_spawnp(&pid_, argv[0], &files, &attributes, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    close(ends[1]);
    input_ = ends[0];
    if (error != 0) {
        close(input_);
        close(output_);
        throw std::system_error(error, std::generic_category(), arguments[0]);
    }
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), input_(std::exchange(other.input_, -1)), output_(std::exchange(other.output_, -1)),
      signal_(other.signal_) {}

ChildProcess::~ChildProcess() {
    wait();
    if (output_ >= 0) close(output_);
}

bool ChildProcess::write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t sent = send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return false;
        bytes = bytes.subspan(sent);
    }
    return true;
}

int ChildProcess::wait() {
    if (input_ >= 0) close(std::exchange(input_, -1));
    if (pid_ < 0) return 0;
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0)
        if (errno != EINTR) return 127;
    pid_ = -1;
    if (WIFSIGNALED(status)) signal_ = WTERMSIG(status);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string ChildProcess::output() const {
    std::string text;
    char buffer[4096];
    for (off_t at = 0; output_ >= 0;) {
        const ssize_t got = pread(output_, buffer, sizeof buffer, at);
        if (got <= 0) break;
        text.append(buffer, got);
        at += got;
    }
    return text;
}

std::vector<std::string> words_of(const std::string& line) {
    std::istringstream in(line);
    return {std::istream_iterator<std::string>(in), {}};
}

std::string last_lines(std::string output, std::size_t most) {
    output.resize(output.find_last_not_of("\r\n") + 1);
    return output.size() <= most ? output : "..." + output.substr(output.size() - most);
}

}  // namespace whorl

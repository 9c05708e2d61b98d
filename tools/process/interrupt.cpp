#include "tools/process/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <initializer_list>

namespace whorl {
namespace {

/// The signal may come to any thread.
std::atomic<bool> received = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void note(int) {
    if (received.exchange(true)) _exit(130);
}

void handle(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
    received = false;
    handle(note);
}
InterruptGuard::~InterruptGuard() { handle(SIG_DFL); }
bool InterruptGuard::interrupted() const { return received; }

}  // namespace whorl

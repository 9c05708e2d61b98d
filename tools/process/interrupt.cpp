#include "tools/process/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <initializer_list>

namespace whorl {
namespace {

volatile sig_atomic_t received = 0;

void note(int) {
    if (received) _exit(130);
    received = 1;
}

void handle(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
    received = 0;
    handle(note);
}
InterruptGuard::~InterruptGuard() { handle(SIG_DFL); }
bool InterruptGuard::interrupted() const { return received != 0; }

}  // namespace whorl

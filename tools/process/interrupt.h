#pragma once
/// SIGINT and SIGTERM as a question that the step loop asks.

namespace whorl {

/// While it lives, the first SIGINT or SIGTERM only sets a flag; the second ends the program at once.
class InterruptGuard {
public:
    InterruptGuard();
    ~InterruptGuard();
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;
    bool interrupted() const;
};

}  // namespace whorl

#include "tools/process/exit_codes.h"

#include <fmt/format.h>

#include <new>
#include <system_error>

#include "engine/core/errors.h"

namespace whorl {

int run_guarded(const std::function<int()>& job) {
    try {
        return job();
    } catch (const InputError& e) {
        for (const Problem& p : e.problems()) fmt::print(stderr, "{}\n", p.message());
        return exit_bad_input;
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "whorl: memory ran out\n  remedy: free some, or allow more (ulimit -v), or take a larger fluid.spacing\n");
        return exit_failed;
    } catch (const std::system_error& e) {
        const bool thread = e.code() == std::errc::resource_unavailable_try_again;
        if (thread)
            fmt::print(stderr, "whorl: a thread cannot be started: {}\n  remedy: allow more memory (ulimit -v) or threads (ulimit -u)\n",
                       e.what());
        else fmt::print(stderr, "whorl: {}\n", e.what());
        return exit_failed;
    } catch (const std::exception& e) {  // EnvironmentError, most of all
        fmt::print(stderr, "whorl: {}\n", e.what());
        return exit_failed;
    }
}

}  // namespace whorl

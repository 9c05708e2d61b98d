#include "tools/process/exit_codes.h"

#include <fmt/format.h>

#include "engine/core/errors.h"

namespace whorl {

int run_guarded(const std::function<int()>& job) {
    try {
        return job();
    } catch (const InputError& e) {
        for (const Problem& p : e.problems()) fmt::print(stderr, "{}\n", p.message());
        return exit_bad_input;
    } catch (const std::exception& e) {  // EnvironmentError, or memory that ran out
        fmt::print(stderr, "whorl: {}\n", e.what());
        return exit_failed;
    }
}

}  // namespace whorl

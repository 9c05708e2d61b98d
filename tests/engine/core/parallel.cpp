#include "engine/core/parallel.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/threads.h"

using namespace whorl;

TEST_CASE("a parallel sum is bit-identical with 1, 2 and 4 threads", "[core]") {
    CHECK(test::same_on_threads([] { return parallel_sum(Index(100003), [](Index i) { return std::sin(0.1 * i) / (1 + i); }); }));
}

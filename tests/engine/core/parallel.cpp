#include "engine/core/parallel.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace whorl;

TEST_CASE("a parallel sum is bit-identical with 1, 2 and 4 threads", "[core]") {
    const Index n = 100003;
    double sums[3];
    int k = 0;
    for (int count : {1, 2, 4}) {
        set_threads(count);
        sums[k++] = parallel_sum(n, [](Index i) { return std::sin(0.1 * i) / (1 + i); });
    }
    set_threads(0);
    REQUIRE(sums[0] == sums[1]);
    REQUIRE(sums[0] == sums[2]);
}
